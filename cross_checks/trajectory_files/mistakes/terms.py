"""A term of the equations that was left out: gravity, or one load."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cross_checks.trajectory_files.mistakes.case import Case, TruthAt
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

LOADS = 16  # a scene with more is not asked for each of them


def left_out(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield the scene without its gravity, and without each of its loads."""
    scene = case.scene
    without: list[tuple[str, Scene]] = []
    if any(scene.gravity):
        without.append(("gravity", scene.model_copy(update={"gravity": tuple(0.0 for _ in scene.gravity)})))
    if len(scene.loads) <= LOADS:
        rest = ((load, tuple(other for other in scene.loads if other is not load)) for load in scene.loads)
        without += [(f"the load {load.name!r}", scene.model_copy(update={"loads": kept})) for load, kept in rest]
    for name, changed in without:
        truth_at = _simulated(changed)
        truth = truth_at(case.path.times)
        if isinstance(truth, Truth):
            yield f"the file moves as the scene does without {name}", replace(case, truth=truth, truth_at=truth_at)


def _simulated(scene: Scene) -> TruthAt:
    def truth_at(times: np.ndarray) -> Truth | NoTruth:
        asked = times if times[0] == 0.0 else np.concatenate(([0.0], times))
        try:
            path = simulate(scene, Settings(rtol=1e-10, estimate="off"), asked)
        except ValueError as error:
            return NoTruth(str(error))
        if not path.ok:
            return NoTruth(path.message)
        kept = slice(len(asked) - len(times), None)
        return Truth(path.position[kept], path.orientation[kept], 0.0, "agreed", "simulated without a term",
                     velocity=path.velocity[kept], angular_velocity=path.angular_velocity[kept],
                     rate_uncertainty=np.zeros(len(times)))  # fmt: skip

    return truth_at
