"""Judge a motion from a program: a trajectory, a file, a data frame or arrays."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cross_checks.judge.consensus import working_truth
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store, default_path
from cross_checks.trajectory_files.columns import OWN
from cross_checks.trajectory_files.judgement import Judgement, judgement
from cross_checks.trajectory_files.mistakes import suspicions
from cross_checks.trajectory_files.mistakes.case import Case, TruthAt
from cross_checks.trajectory_files.motion import Read, read_motion
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

DEFAULT_ERROR = 1e-6  # of the scene's scales: a motion with a smaller error agrees with the truth


def judge(
    motion: Trajectory | str | Path | Mapping[str, Any] | Any, scene: Scene, *, error: float = DEFAULT_ERROR,
    column_map: str | Path | None = None,
) -> Judgement:  # fmt: skip
    """Return the verdict on a motion of a scene, with the errors of every body and component.

    `motion` is a Trajectory, a file (CSV, NPZ, Parquet), a data frame, or arrays by name: (n_rows,) is one column,
    (n_rows, k) are the columns name[0] to name[k - 1]. The TOML file `column_map` states units, axes and conventions of
    the columns; columns named as by `mbs-ref simulate -o` need none. `error` is a share of the scene's scales.

    Raises FileError, a ValueError that names the column and what is expected.
    """
    read = read_motion(_source(motion, scene), scene, None if column_map is None else Path(column_map))
    with Store(default_path()) as store:
        return judged(scene, read, truth_at(Runs(store), scene), error)


def judged(scene: Scene, read: Read, at: TruthAt, error: float) -> Judgement:
    """Return the verdict on a motion that is read, with the mistakes that would explain its error."""
    truth = at(read.told.path.times)
    verdict = judgement(scene, read.told, truth, error)
    if verdict.verdict != "departs" or not isinstance(truth, Truth):
        return verdict
    case = Case(scene, read.columns, read.stated, read.told.path, truth, at)
    return replace(verdict, suspicions=tuple(suspicions(case, error)))


def _source(motion: Any, scene: Scene) -> Path | dict[str, np.ndarray]:
    if isinstance(motion, str | Path):
        return Path(motion)
    if isinstance(motion, Trajectory):
        return {"bodies": np.array(scene.body_names), **{name: getattr(motion, name) for name in OWN - {"bodies"}}}
    return {str(name): np.asarray(motion[name]) for name in getattr(motion, "columns", motion)}


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
        return _rows(consensus, np.isin(requested, times)) if isinstance(consensus, Truth) else consensus

    return at


def _rows(truth: Truth, rows: np.ndarray) -> Truth:
    arrays: dict[str, Any] = {name: value[rows] for name, value in vars(truth).items() if isinstance(value, np.ndarray)}
    return replace(truth, **arrays)
