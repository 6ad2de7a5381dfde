"""The truth of a scene at the times that a file has."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cross_checks.judge.consensus import working_truth
from cross_checks.judge.runs import Runs
from cross_checks.trajectory_files.mistakes.case import TruthAt
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import Scene


def truth_at(runs: Runs, scene: Scene) -> TruthAt:
    """Return what gives the truth at any times (s, increasing, from 0 to the scene's duration).

    Where none is certified, it is what unlike engines agree on at those times.
    """

    def at(times: np.ndarray) -> Truth | NoTruth:
        known = runs.truth(scene, times)
        if isinstance(known, Truth):
            return known
        asked = np.union1d(0.0, times)  # a run begins at 0
        agreed = working_truth(replace(runs, times=asked), scene, known.reason)
        return _rows(agreed, np.isin(asked, times)) if isinstance(agreed, Truth) else agreed

    return at


def _rows(truth: Truth, rows: np.ndarray) -> Truth:
    arrays: dict[str, Any] = {name: value[rows] for name, value in vars(truth).items() if isinstance(value, np.ndarray)}
    return replace(truth, **arrays)
