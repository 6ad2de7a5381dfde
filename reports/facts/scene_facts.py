"""What a page states of a scene: its data and film, its truth and the certificate of that."""

from dataclasses import dataclass, replace

import numpy as np

from cross_checks.metrics.metric import known_to
from cross_checks.truths import certificate
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Settings, Trajectory, scenes
from mbs_ref.observables.distance import Partial, farthest
from mbs_ref.scene.scales import scales_of
from mbs_ref.simulate import simulate
from reports.facts.curves import Film, film
from reports.film.drawing import ARCS, arcs, is_apart
from reports.scene_summary import Summary, summary

PICTURES = 40  # of a film
MOST_BODIES = 120  # of a scene that is filmed: others take minutes
MOST_BULGE = 0.01  # of the picture's size, between two pictures: 15 a turn


@dataclass(frozen=True)
class SceneFacts:
    """The mechanism of a scene."""

    scene: str  # its label
    description: str
    source: str  # where the data come from; empty where they are this project's own
    duration: float  # s
    summary: Summary
    film: Film | None
    unfilmed: str = ""  # why there is no film


def scene_facts(scene: Scene) -> SceneFacts:
    """Return a scene's facts; it is simulated by the default method."""
    path, why = filmed(scene)
    shown = None if path is None else film(scene, path, 1)
    label = scenes.label(scene.name, scene.parameters)
    return SceneFacts(label, scene.description, scene.source, scene.duration, summary(scene), shown, why)


def filmed(scene: Scene) -> tuple[Trajectory | None, str]:
    """Return the motion that a film shows, or None and the sentence why there is none.

    Of bodies on orbits it is as long as its pictures are dense enough to follow them.
    """
    if len(scene.bodies) > MOST_BODIES:
        again = f"`mbs-ref animate {scene.name} -o film.gif` films it"
        return None, f"Not filmed here: {len(scene.bodies)} bodies; {again}"
    path = simulate(scene, Settings(samples=PICTURES, estimate="off", reactions=False))
    if path.ok and is_apart(scene) and _bulge(path) > MOST_BULGE:
        return filmed(scene.model_copy(update={"duration": 0.5 * scene.duration}))
    return (path, "") if path.ok else (None, f"Not filmed: {path.message}")


def _bulge(path: Trajectory) -> float:
    """Return how far orbits leave the lines between samples: the mean of the largest, over the size of the picture."""
    way, place = arcs(path)[ARCS // 2 :: ARCS], path.position
    off = np.linalg.norm(way - 0.5 * (place[:-1] + place[1:]), axis=2).max(axis=1)
    return float(np.mean(off)) / max(float(np.ptp(place, axis=(0, 1)).max()), 1e-300)


@dataclass(frozen=True)
class TruthFacts:
    """One scene's truth, or the reason for having none. Lengths in m."""

    scene: str  # label, with parameters
    none: str = ""  # why there is no truth; empty where there is one
    kind: str = ""
    how: str = ""
    uncertainty: float | None = None
    known_to: float | None = None  # over the scene: of poses, in the measure of the error
    difference: float | None = None  # between two unlike ways; None where there is one alone
    length: float | None = None  # of the scene
    certified: str = ""  # date of its certificate; empty without one
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
