"""The truth of a scene at the times that a file has."""

from __future__ import annotations

import numpy as np

from cross_checks.judge.runs import Runs
from cross_checks.trajectory_files.mistakes.case import TruthAt
from cross_checks.truth import NoTruth, Truth
from cross_checks.truths import seek_truth
from mbs_ref.scene import Scene


def truth_at(runs: Runs, scene: Scene) -> TruthAt:
    """Return what gives the truth at any times (s, increasing, from 0 to the scene's duration)."""

    def at(times: np.ndarray) -> Truth | NoTruth:
        return runs.call(seek_truth, scene, times)

    return at
