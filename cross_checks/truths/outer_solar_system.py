"""The outer planets, converged from the published start."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.sky.particles import converge
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Return the motion under the scene's own forces."""
    return converge(scene, times)
