"""Distance of the bodies from where they should be."""

from __future__ import annotations

import numpy as np

from cross_checks.truths import Truth
from mbs_ref.trajectory import Trajectory


def pose_error(trajectory: Trajectory, truth: Truth) -> np.ndarray:
    """Return the largest distance over bodies of centres of mass from the truth (n_t,), m.

    The truth may go on after the trajectory has stopped; the samples reached are compared.
    """
    if truth.origin is None:
        return distance(trajectory.position, truth.position)
    return _seen_from_origin(trajectory.position, truth)


def _seen_from_origin(position: np.ndarray, truth: Truth) -> np.ndarray:
    """Compare what the truth covers, as seen from its origin: the body whose name it gives comes first in the scene."""
    kept = [k for k in range(position.shape[1]) if truth.covers(k)]
    own, true = (part[:, kept] - part[:, :1] for part in (position, truth.position))
    return distance(own, true)


def distance(position: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the largest distance over bodies (n_t,), m, of two sets of world points over their common samples."""
    n = min(len(position), len(other))
    return np.max(np.linalg.norm(position[:n] - other[:n], axis=2), axis=1)
