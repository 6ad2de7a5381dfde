"""The figure of eight, converged: the published start has eight digits and closes to as many."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.sky.particles import converge
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth | NoTruth:
    """Return the motion from the start as it is rounded."""
    return converge(scene, times)
