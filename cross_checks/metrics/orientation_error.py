"""Angle between the bodies' orientations and the true ones."""

from __future__ import annotations

import numpy as np

from cross_checks.truths import Truth
from mbs_ref.scene.euler_parameters import geodesic_angle
from mbs_ref.trajectory import Trajectory


def orientation_error(trajectory: Trajectory, truth: Truth) -> np.ndarray:
    """Return the geodesic angle from the truth (n_t, n_bodies), rad, over their common samples; spatial scenes."""
    n = min(len(trajectory.orientation), len(truth.angle))
    return geodesic_angle(trajectory.orientation[:n], truth.angle[:n])
