"""Where runs of fixed steps lead: the leading term of their error taken away (Richardson, Phil. Trans. A 226, 1927)."""

from dataclasses import replace

import numpy as np

from mbs_ref import Trajectory


def extrapolated(coarse: Trajectory, fine: Trajectory, ratio: float, order: float) -> Trajectory:
    """Return the limit of two runs whose steps are `ratio` > 1 apart and whose error is C h^order.

    Of places, turns and their rates. Whole turns in the plane do not count; Euler parameters have norm 1 again.
    """
    share = 1.0 / (ratio**order - 1.0)
    turns = fine.orientation + share * _turned(coarse.orientation, fine.orientation)
    if turns.ndim == 3:
        turns /= np.linalg.norm(turns, axis=2, keepdims=True)
    return replace(
        fine, orientation=turns,
        position=fine.position + share * (fine.position - coarse.position),
        velocity=fine.velocity + share * (fine.velocity - coarse.velocity),
        angular_velocity=fine.angular_velocity + share * (fine.angular_velocity - coarse.angular_velocity),
    )  # fmt: skip


def _turned(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the shorter way from one orientation to the other: angles in the plane, else Euler parameters."""
    if after.ndim == 2:
        return np.remainder(after - before + np.pi, 2.0 * np.pi) - np.pi
    opposite = np.sum(before * after, axis=2, keepdims=True) < 0.0
    return after - np.where(opposite, -before, before)
