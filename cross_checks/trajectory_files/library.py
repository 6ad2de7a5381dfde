"""Judge a motion from a program: a trajectory, a file, a data frame or arrays."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks.judge.consensus import working_truth
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store, default_path
from cross_checks.trajectory_files.formats import OWN, FileError
from cross_checks.trajectory_files.judgement import Judgement, judgement, truth_rows
from cross_checks.trajectory_files.mistakes import suspicions
from cross_checks.trajectory_files.mistakes.case import Case
from cross_checks.trajectory_files.motion import Read, read_motion
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene
from mbs_ref.trajectory import Trajectory

TruthAt = Callable[[np.ndarray], Truth | NoTruth]  # of times (n_t,), s
MOST_EXPLAINED = 1000  # rows, besides the worst, at which mistakes are fitted
DEFAULT_ERROR = 1e-6  # of the scene's scales: a motion with a smaller error agrees with the truth


def judge(
    scene: Scene, motion: Any, poses: Any = None, rates: Any = None, *, error: float = DEFAULT_ERROR,
    column_map: str | Path | None = None,
) -> Judgement:  # fmt: skip
    """Return the verdict on a motion of a scene, with the errors of every body and component.

    With `poses` the motion is its times (n,), s. Poses are (n, n_bodies, 3), m and rad, in the plane and
    (n, n_bodies, 7), m and Euler parameters from body to world axes, in space; rates are (n, n_bodies, 3) or
    (n, n_bodies, 6), m/s and rad/s along world axes. Positions and velocities alone are allowed, with as many
    components as the scene has dimensions. The axis of bodies may be left out.

    Without `poses` the motion is a Trajectory, a file (CSV, NPZ, Parquet), a data frame, or arrays by name: (n_rows,)
    is one column, (n_rows, k) are the columns name[0] to name[k - 1]. The TOML file `column_map` states units, axes and
    conventions of the columns; columns named as by `mbs-ref simulate -o` need none. `error` is a share of the scene's
    scales.

    Raises FileError, a ValueError that names the column or array and what is expected.
    """
    source = _source(motion, scene) if poses is None else _columns(scene, motion, poses, rates)
    read = read_motion(source, scene, None if column_map is None else Path(column_map))
    with Store(default_path()) as store:
        return judged(scene, read, truth_at(Runs(store), scene), error)


def judged(scene: Scene, read: Read, at: TruthAt, error: float) -> Judgement:
    """Return the verdict on a motion that is read, with the mistakes that would explain its error."""
    truth = at(read.motion.path.times)
    verdict = judgement(scene, read.motion, truth, error)
    if verdict.verdict != "departs" or not isinstance(truth, Truth):
        return verdict
    times, worst = read.motion.path.times, [part.at for part in verdict.parts if part.at is not None]
    rows = np.linspace(0.0, len(times) - 1.0, min(len(times), MOST_EXPLAINED)).astype(int)
    rows = np.union1d(rows, np.searchsorted(times, worst))
    path, columns = read.motion.path.at(rows), read.columns.at(rows)
    return replace(
        verdict, suspicions=tuple(suspicions(Case(scene, columns, read.stated, path, truth_rows(truth, rows)), error))
    )


def _source(motion: Any, scene: Scene) -> Path | dict[str, np.ndarray]:
    if isinstance(motion, str | Path):
        return Path(motion)
    if isinstance(motion, Trajectory):
        return {"bodies": np.array(scene.body_names), **{name: getattr(motion, name) for name in OWN - {"bodies"}}}
    return {str(name): np.asarray(motion[name]) for name in getattr(motion, "columns", motion)}


def _columns(scene: Scene, times: Any, poses: Any, rates: Any) -> dict[str, np.ndarray]:
    """Return the columns of arrays, named as in the files that `mbs-ref simulate -o` writes."""
    words, first = scene.world.columns, scene.dimension + np.size(scene.world.unturned)
    columns, n = {"t": np.asarray(times)}, len(scene.bodies)
    for name, own, value in (("poses", words[:first], poses), ("rates", words[first:], rates)):
        if value is None:
            continue
        rows, allowed = np.asarray(value), [(len(columns["t"]), n, width) for width in (scene.dimension, len(own))]
        shape = next((one for one in allowed if rows.shape in (one, (one[0], one[2] * n))), None)
        if shape is None:
            expected = " or ".join(map(str, allowed))
            raise FileError(f"{name} has the shape {rows.shape}; expected: {expected}")
        every = rows.reshape(shape)
        columns |= {f"{b}.{own[c]}": every[:, k, c] for k, b in enumerate(scene.body_names) for c in range(shape[2])}
    return columns


def truth_at(runs: Runs, scene: Scene) -> TruthAt:
    """Return a function of times (s, increasing, from 0 to the scene's duration) that returns the truth.

    Where none is certified, it is a consensus of unlike engines at those times.
    """

    def at(times: np.ndarray) -> Truth | NoTruth:
        known = runs.truth(scene, times)
        if isinstance(known, Truth):
            return known
        requested = np.union1d(0.0, times)  # a run begins at 0
        consensus = working_truth(replace(runs, times=requested), scene, known.reason)
        return truth_rows(consensus, np.isin(requested, times)) if isinstance(consensus, Truth) else consensus

    return at
