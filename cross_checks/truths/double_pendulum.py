"""The double pendulum: a chain of two unlike rods."""

from __future__ import annotations

import numpy as np

from cross_checks.truth import Truth
from cross_checks.truths.pendulum_chain import converged, rods_of
from mbs_ref.scene import Scene


def solve(scene: Scene, times: np.ndarray) -> Truth:
    """Converge the chain's equations for two rods."""
    length = np.array([scene.parameters["length_1"], scene.parameters["length_2"]], dtype=float)
    return converged(rods_of(scene, length), times)
