"""Velocities of a truth that gives poses: differences of order six, with an error bar from other differences."""

from collections.abc import Callable

import numpy as np

from mbs_ref.scene.euler_parameters import conjugate, product, rotation_vector
from mbs_ref.scene.scales import Scales

OFFSETS = np.arange(-3, 4)
SIXTH = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60.0  # f' of order 6 (Fornberg 1988, table 1)
FOURTH = np.array([0, 1, -8, 0, 8, -1, 0]) / 12.0
AROUND = np.arange(-6, 7)
CENTRAL = np.pad(SIXTH, 3)
FORWARD = np.concatenate((np.zeros(6), [-147, 360, -450, 400, -225, 72, -10])) / 60.0  # order 6 (ibid., table 3)
RESOLVED = 1e-3  # of the scene's rates: where central and one-sided derivatives differ by more, none is known
WIDTH = 0.02  # of the interval between outputs, or of the scene's time scale where that is shorter
SHORT = 2e-3  # of the time in which a state changes by its own size
AMPLIFIED = float(np.abs(SIXTH).sum())  # of an error in the values

Poses = tuple[np.ndarray, np.ndarray]  # position (n_bodies, d) m, orientation (n_bodies,) rad or (n_bodies, 4)


def along(derivative: Callable, poses: Callable, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the velocities at (t, y), the slopes of poses(t + s, y + s y') at s = 0, and how well they are known."""
    slope = derivative(t, y)
    h = SHORT / (1.0 + float(np.max(np.abs(slope) / (1.0 + np.abs(y)))))
    velocity, turning, *doubts = _slopes([poses(t + s, y + s * slope) for s in h * OFFSETS], h, (SIXTH, FOURTH))
    return velocity, turning, max(doubts)


def stencil_times(times: np.ndarray, scale: float) -> tuple[np.ndarray, float]:
    """Return every time (s) that `of_poses` needs, and the step between them; none lies before 0.

    `scale` (s) is the scene's: over whole periods of a motion differences would see none.
    """
    h = WIDTH * min(scale, float(np.min(np.diff(times))))
    return np.unique(np.concatenate([(times + j * h)[times + j * h >= 0.0] for j in AROUND])), h


def of_poses(
    times: np.ndarray, h: float, at: np.ndarray, poses: Poses, uncertainty: float, scales: Scales
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the rates at `times` from poses at the times `at` (see stencil_times), known to `uncertainty` (m).

    They are velocities (n_t, n_bodies, d), angular velocities (n_t, n_bodies) or (n_t, n_bodies, 3), and how well both
    are known (n_t,), in m/s and rad/s.

    The error bar is the difference of the central from both one-sided derivatives of the same order: across a jump
    the central one is the mean of both sides, at any place of the jump. At the start, which no pose precedes, and
    where the derivatives agree to fewer than three digits of the scene's rates, the uncertainty is infinite.
    """
    position, orientation = poses
    first = np.full(len(times), np.inf)
    velocity = np.zeros((len(times), *position.shape[1:]))
    spin = np.zeros((*velocity.shape[:2], 3) if velocity.shape[2] == 3 else velocity.shape[:2])
    for k, t in enumerate(times):
        if t + h * AROUND[0] < 0.0:
            continue
        places = np.searchsorted(at, t + h * AROUND - 1e-9 * h)
        here = [(position[j], orientation[j]) for j in places]
        velocity[k], turning, *doubts = _slopes(here, h, (CENTRAL, FORWARD, -FORWARD[::-1]))
        spin[k] = turning if turning.ndim == spin.ndim - 1 else 0.0  # particles have no orientation
        if max(doubts[0] / scales.speed, doubts[1] * scales.time) < RESOLVED:
            first[k] = max(doubts) + AMPLIFIED * uncertainty / h
    return velocity, spin, first


def _slopes(
    poses: list[Poses], h: float, stencils: tuple[np.ndarray, ...]
) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return velocity and angular velocity by the first stencil, and the largest differences by the others."""
    slopes = [[np.tensordot(weights, values, 1) / h for weights in stencils]
              for values in (np.array([one[0] for one in poses]), _turns([one[1] for one in poses]))]  # fmt: skip
    doubts = [max(float(np.max(np.abs(first - one), initial=0.0)) for one in others) for first, *others in slopes]
    return slopes[0][0].astype(float), slopes[1][0].astype(float), doubts[0], doubts[1]


def _turns(orientation: list[np.ndarray]) -> np.ndarray:
    """Return angles, or in space the rotation vectors (world axes) from the middle orientation to each."""
    values = np.array(orientation)
    if values.ndim == 2:
        return values
    return rotation_vector(product(values, conjugate(values[len(values) // 2])[None]))
