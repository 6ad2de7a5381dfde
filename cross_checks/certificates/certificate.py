"""Certificates of truths: how well each is known, how that was found, and its digits, kept on disk."""

from __future__ import annotations

import json
import math
import platform
import re
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.certify import kept_poses
from cross_checks.certify.kept_poses import KeptPoses
from cross_checks.judge import ladder
from cross_checks.judge.one_run import evaluate
from cross_checks.truth import MARGIN, NoTruth, Truth
from cross_checks.truths import seek_truth
from mbs_ref import scenes
from mbs_ref.atomic_file import write_atomic
from mbs_ref.observables.distance import Partial, unmasked_distances
from mbs_ref.scene import Scene

FOLDER = Path(__file__).parent / "kept"
MAKERS = ("numpy", "scipy")  # whose versions may matter; extended precision is the processor's


@dataclass(frozen=True)
class Certificate:
    """What is known of one truth. Lengths in m, times in s."""

    scene: str
    parameters: dict[str, Any]
    t_end: float
    samples: int
    kind: str  # exact | published | converged | ephemeris
    how: str
    uncertainty: float  # of every world point at every time
    difference: float | None  # between two unlike ways; None where the truth is known in one
    end: dict[str, list[float | None]]  # body -> centre of mass at t_end; None where the truth does not cover it
    confirmed_by: str  # a run of the reference solver, which takes no part in making the truth
    confirmed_to: float | None  # its largest distance from the truth
    made: str  # UTC date
    versions: dict[str, str]

    @property
    def floor(self) -> float:
        """The smallest error that this truth judges."""
        return MARGIN * self.uncertainty

    @property
    def decimals(self) -> int:
        """Decimals of `end` that hold."""
        return max(0, math.floor(-math.log10(2.0 * self.uncertainty)))


def certify(scene: Scene, confirm: bool = True) -> Certificate | NoTruth:
    """Make the scene's truth afresh on the grid of judged runs and state what is known of it."""
    times = ladder.grid(scene)
    truth = seek_truth(scene, times, afresh=True)
    if isinstance(truth, NoTruth):
        return truth
    by, to = _confirmation(scene) if confirm else ("", None)
    return Certificate(
        scene.name, dict(scene.parameters), float(times[-1]), len(times), truth.kind, truth.how, truth.uncertainty,
        truth.difference, _end(scene, truth), by, to, datetime.now(UTC).strftime("%Y-%m-%d"), _versions(),
    )  # fmt: skip


def keep_poses(scene: Scene) -> Path | None:
    """Make the scene's truth afresh and keep its poses where it takes long to make; return their file."""
    times = ladder.grid(scene)
    truth = seek_truth(scene, times, afresh=True)
    if isinstance(truth, NoTruth) or not truth.is_costly or truth.difference is None or truth.velocity is None:
        return None
    assert truth.angular_velocity is not None
    assert truth.rate_uncertainty is not None
    poses = KeptPoses(
        times, truth.position, truth.orientation, truth.velocity, truth.angular_velocity, truth.rate_uncertainty,
        truth.uncertainty, truth.difference, truth.how,
    )  # fmt: skip
    return kept_poses.keep(scene, poses)


def _confirmation(scene: Scene) -> tuple[str, float | None]:
    """Run the reference solver at its finest: it shares the scene's data with the truth, and no code of motion."""
    solver = engines.get("mbs_ref")
    fit = [method for method in solver.methods() if not solver.method_refusals(scene, method)]
    if solver.refusals(scene) or not fit:
        return "the reference solver does not run it", None
    finest = ladder.rungs(fit[0], scene)[-1]
    record = evaluate(scene, solver.name, finest, ladder.grid(scene))
    by = f"{solver.name} {fit[0].name} {ladder.label(finest)}"
    if record.error is None:
        return f"{by} does not finish: {record.message}", None
    return by, record.at_most("position_error")


def _end(scene: Scene, truth: Truth) -> dict[str, list[float | None]]:
    places = truth.position[-1].tolist()
    return {
        name: [x if math.isfinite(x) else None for x in place]
        for name, place in zip(scene.body_names, places, strict=True)
    }


def _versions() -> dict[str, str]:
    digits = np.finfo(np.longdouble).precision
    versions = {name: version(name) for name in MAKERS}
    return {"python": platform.python_version(), **versions, "extended precision": f"{digits} digits"}


def departure(stored: Certificate, fresh: Certificate) -> float:
    """Return how far (m) the ends of two certificates of one truth are apart; ValueError where they are of two."""
    if (stored.scene, stored.parameters, stored.t_end) != (fresh.scene, fresh.parameters, fresh.t_end):
        raise ValueError(f"{file_name(stored)} and {file_name(fresh)} certify different truths")
    return float(unmasked_distances(_end_of(stored), _end_of(fresh), None)[..., 0].max())


def holds(stored: Certificate, fresh: Certificate) -> bool:
    """Whether the truth made again is the stored one, to what both claim to know."""
    return departure(stored, fresh) <= stored.uncertainty + fresh.uncertainty


def _end_of(certificate: Certificate) -> Partial:
    return Partial(np.array([[[0.0 if x is None else x for x in place] for place in certificate.end.values()]]))


def file_name(certificate: Certificate | Scene) -> str:
    """Return the name of the file that holds a truth's certificate: the scene and what is not its default."""
    name = certificate.name if isinstance(certificate, Scene) else certificate.scene
    defaults = scenes.describe(name).parameters
    chosen = [f"{key}={value}" for key, value in certificate.parameters.items() if defaults.get(key) != value]
    return re.sub(r"[^\w=.+-]+", "_", " ".join([name, *chosen])) + ".json"


def write(certificate: Certificate, folder: Path = FOLDER) -> Path:
    """Keep a certificate; return its file."""
    target = folder / file_name(certificate)
    folder.mkdir(parents=True, exist_ok=True)
    write_atomic(target, (json.dumps(asdict(certificate), indent=1, allow_nan=False) + "\n").encode())
    return target


def stored(scene: Scene, folder: Path = FOLDER) -> Certificate | None:
    """Return the certificate kept for a scene with its parameters, or None."""
    file = folder / file_name(scene)
    kept = read(file) if file.is_file() else None
    return kept if kept is not None and kept.parameters == scene.parameters else None


def read(file: Path) -> Certificate:
    """Return the certificate in a file; ValueError names the file where it holds none.

    Of a scene that has gained parameters since, it certifies their defaults: what was made before they were.
    """
    try:
        kept = Certificate(**json.loads(file.read_text()))
    except (ValueError, TypeError) as error:
        raise ValueError(f"{file} holds no certificate: {error}") from error
    defaults = scenes.describe(kept.scene).parameters if kept.scene in scenes.names() else {}
    return replace(kept, parameters=defaults | kept.parameters)


def every(folder: Path = FOLDER) -> list[Certificate]:
    """Return every certificate kept."""
    return [read(file) for file in sorted(folder.glob("*.json"))]
