"""Particles, which have no orientation, in the trajectory's terms."""

from __future__ import annotations

import numpy as np


def of_particles(position: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return poses of particles in space from positions and velocities, each (n_t, n_bodies, 3): they never turn."""
    turn = np.zeros((*position.shape[:2], 4))
    turn[:, :, 0] = 1.0
    return position, turn, velocity, np.zeros_like(velocity)
