"""What the report says of each scene's truth, and of the certificate kept of it."""

from dataclasses import dataclass, replace

import numpy as np

from cross_checks.metrics.metric import known_to
from cross_checks.truths import certificate
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene import Scene
from mbs_ref.scene.scales import scales_of


@dataclass(frozen=True)
class TruthFacts:
    """One scene's truth, or the reason for having none. Lengths in m."""

    scene: str  # label, with parameters
    none: str = ""  # why there is no truth; empty where there is one
    kind: str = ""
    how: str = ""
    uncertainty: float | None = None
    known_to: float | None = None  # over the scene: of poses, in the measure of the error
    difference: float | None = None  # between two unlike ways; None where it was found in one
    length: float | None = None  # of the scene
    certified: str = ""  # when its certificate was made; empty without one
    confirmed_by: str = ""
    confirmed_to: float | None = None
    departs_by: float | None = None  # from the certificate, at the end


def truth_facts(label: str, scene: Scene, truth: Truth | NoTruth) -> TruthFacts:
    """Return the facts of one labelled scene."""
    if isinstance(truth, NoTruth):
        return TruthFacts(label, none=truth.reason)
    certified = certificate.stored(scene)
    facts = TruthFacts(
        label, "", truth.kind, truth.how, truth.uncertainty, known_to(scene, truth), truth.difference,
        scales_of(scene).length,
    )  # fmt: skip
    if certified is None:
        return facts
    return replace(
        facts, certified=certified.made, confirmed_by=certified.confirmed_by, confirmed_to=certified.confirmed_to,
        departs_by=_departure(scene, truth, certified.end),
    )  # fmt: skip


def _departure(scene: Scene, truth: Truth, end: dict[str, list[float | None]]) -> float | None:
    """Return the largest distance (m) between where the truth and its certificate end."""
    places = np.array([[end[name] for name in scene.body_names]], dtype=float)
    apart = farthest(scene, Partial(truth.position[-1:]), Partial(places))[0]
    return apart if np.isfinite(apart) else None
