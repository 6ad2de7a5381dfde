"""The vertebral android: the simplified one's truth with more bodies, and half a minute in the making."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cross_checks.truth import NoTruth, Truth
from cross_checks.truths.android_simplified import crash_truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Converge the vertebral android."""
    truth = crash_truth(scene, times)
    return truth if isinstance(truth, NoTruth) else replace(truth, is_costly=True)
