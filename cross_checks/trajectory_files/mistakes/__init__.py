"""Which mistakes explain a file's error: every change of a table of hypotheses is tried, and its size is fitted.

A hypothesis is one change of what the columns mean or of the scene that was simulated. It is named if the error
without it is EXPLAINS times less, and no other leaves less. Of those that leave as little, one without a fitted number
comes first; the search goes on from there, since a file may have several mistakes. Where nothing explains what remains,
errors of integration are looked for: from sample to
sample the file departs from the scene's equations, and irregularly. A wrong term of the equations acts along the whole
motion and changes as slowly as the motion does; an integrator with a loose tolerance errs by another amount in each of
its steps.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cross_checks.trajectory_files.mistakes.case import RERUN, Case, Explanation, explanations
from cross_checks.trajectory_files.mistakes.frames import clocks, conventions, frames, signs
from cross_checks.trajectory_files.mistakes.terms import terms
from mbs_ref.cores.system import Poses
from mbs_ref.scene import PointMass
from mbs_ref.scene.signals import Constant
from mbs_ref.scene.traits import traits
from mbs_ref.simulate import simulate

KINDS = (conventions, signs, frames, clocks, terms)
EXPLAINS = 10.0  # times less error: that is no accident
ALIKE = 3.0  # explanations that leave no more than this many times as much as the best explain as well
MOST = 4  # mistakes looked for in one file


def suspicions(case: Case, limit: float) -> list[str]:
    """Return a sentence for each mistake, the one that explains most first; none where nothing explains the error."""
    sentences: list[str] = []
    while case.error > limit and len(sentences) < MOST:
        every = [one for one in _every(case) if one.case.error * EXPLAINS < case.error]
        if not every:
            sentences += filter(None, [integration_errors(case)])
            break
        least = min(one.case.error for one in every)
        alike = [one for one in every if one.case.error <= max(ALIKE * least, limit)]
        alike.sort(key=lambda one: (one.numbers, one.case.error))  # the simplest first
        best = alike[0]
        said = dict.fromkeys(one.sentence for one in alike if one.numbers == best.numbers)
        remains = f"without that the error is {best.case.error:.2g} of the scene, not {case.error:.2g}"
        sentences.append(f"{', or '.join(said)}: {remains}")
        case = best.case
    return sentences


def _every(case: Case) -> Iterator[Explanation]:
    with np.errstate(all="ignore"):
        for kind in KINDS:
            for hypothesis in kind(case):
                yield from explanations(case, hypothesis)


IRREGULAR = 2.0  # times as rough as the motion's own changes
SPREAD = 1e-3  # of the largest departure: the median one is larger, unless they are all at a few events
STRETCHES = 200  # at most
STRETCH = RERUN.model_copy(update={"project_initial": True})


def integration_errors(case: Case) -> str:
    """Return a sentence where the file's departures between samples are irregular; nothing where they are not."""
    departures = _departures(case)
    if departures is None:
        return ""
    count, sizes = len(departures), np.abs(departures).max(axis=1)
    own = _roughness(np.diff(case.path.velocity[: count + 1].reshape(count + 1, -1), axis=0))
    if not (_roughness(departures) > IRREGULAR * own and np.median(sizes) > SPREAD * sizes.max()):
        return ""
    return (
        "the tolerance or the step looks too loose: from one sample to the next the file departs from the scene's "
        f"equations by {np.median(sizes):.2g} of the scene, at most {sizes.max():.2g}, as no wrong term does"
    )


def _roughness(changes: np.ndarray) -> float:
    """Return how much rows (n, m) differ from their neighbours: 0 where all are equal, 0.7 where they are unrelated."""
    return float(np.linalg.norm(np.diff(changes, axis=0)) / (2.0 * np.linalg.norm(changes)))


def _departures(case: Case) -> np.ndarray | None:
    """Return how far each sample is from a run that starts at the one before (n - 1, m), of the scene's scales.

    None where no run can start there: unknown poses or velocities, another clock, equations that contain the time.
    """
    scene, path = case.assumed or case.scene, case.path
    timed = "rheonomic" in traits(scene) or any(load.type == "epoch" for load in scene.loads) or any(
        not isinstance(signal, Constant) for part in scene.loads for signal in part.signals
    )  # fmt: skip
    particles = [isinstance(body, PointMass) for body in scene.bodies]
    known = [~np.isnan(part) for part in Poses.of(path)]
    known[1][:, particles] = known[3][:, particles] = True
    if timed or case.late or case.rates_late or not all(part.all() for part in known):
        return None
    rows = []
    for k in range(min(len(path.times) - 1, STRETCHES)):
        start = Poses(*(np.nan_to_num(part[k : k + 1]) for part in Poses.of(path)))
        try:
            run = simulate(scene, STRETCH, path.times[k : k + 2] - path.times[k], start)
        except ValueError:
            return None
        if not run.ok:
            return None
        end = {name: part[-1:] for name, part in Poses.of(run)._asdict().items()}
        rows.append(replace(case.at(np.array([k + 1])), truth=replace(case.truth, **end)).gaps)
    return np.array(rows)
