"""Figures of one run, from its poses and velocities alone, each relative to the scene's own size, speed or energy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cross_checks.conformance.questions import Asked
from cross_checks.truths.truth import Truth
from mbs_ref.observables import constraint_residual, energy_balance, kinetic_energy
from mbs_ref.observables.distance import farthest
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.trajectory import Trajectory

# central differences of order 6 and 8: weights of x(t + k d) - x(t - k d), k = 1, 2, ...
SIXTH = (3 / 4, -3 / 20, 1 / 60)
EIGHTH = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
WIDTH = len(EIGHTH)


def size(question: Asked) -> float:
    """Return the largest distance between two places a body's centre or another body passes, m; 1 where all rest."""
    places = question.truth.position.reshape(-1, question.scene.dimension)
    return float(np.linalg.norm(np.ptp(places, axis=0))) or 1.0


def turning(scene: Scene) -> np.ndarray:
    """Return which bodies have an orientation, (n_bodies,)."""
    return np.array([isinstance(body, PlanarBody | SpatialBody) for body in scene.bodies])


def axes(scene: Scene, orientation: np.ndarray) -> np.ndarray:
    """Return rotation matrices (n_t, n_bodies, d, d) of a trajectory's orientations."""
    if scene.dimension == 3:
        return rotation_matrices(orientation)
    c, s = np.cos(orientation), np.sin(orientation)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)


def apart(question: Asked, one: Trajectory, other: Trajectory | Truth) -> float:
    """Return how far two motions are apart: the larger of positions over the scene's size and of orientations, rad."""
    place, turn, *_ = farthest(question.scene, one, other)
    return float(np.fmax(place / size(question), turn))


def slope_mismatch(scene: Scene, path: Trajectory, roundoff: float) -> tuple[float, float]:
    """Return by how much velocities miss the slope of positions, over the largest speed, and how sure that is.

    Angular velocities are held against the slope of the rotation matrices, R' = omega x R, and count over the scene's
    size: where nothing turns its speed is the measure. The median over samples is taken: a short transient, or the jump
    of an impact, is not resolved by the samples. Places are known to `roundoff`, relative.
    """
    straight = _misses(path.position, path.velocity, path.times, roundoff)
    bodies = turning(scene)
    if not bodies.any():
        return straight.over(straight.fastest or 1.0)
    turned = axes(scene, path.orientation)[:, bodies]
    round_about = _misses(turned, _spun(scene, path.angular_velocity[:, bodies], turned), path.times, roundoff)
    length = float(np.linalg.norm(np.ptp(path.position.reshape(-1, scene.dimension), axis=0))) or 1.0
    fastest = max(straight.fastest, length * round_about.fastest) or 1.0
    return tuple(map(max, straight.over(fastest), round_about.over(fastest / length)))  # type: ignore[return-value]


def _spun(scene: Scene, omega: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """Return R' = omega x R."""
    if scene.dimension == 3:
        return np.cross(omega[..., None, :], np.swapaxes(turned, -1, -2)).swapaxes(-1, -2)
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    return omega[..., None, None] * (quarter @ turned)


class _Misses(NamedTuple):
    """How far rates are from slopes at each inner sample, how sure slopes are, and the largest slope."""

    miss: np.ndarray  # (n,)
    unsure: np.ndarray  # (n,)
    fastest: float

    def over(self, scale: float) -> tuple[float, float]:
        return float(np.median(self.miss)) / scale, float(np.median(self.unsure)) / scale


def _misses(x: np.ndarray, rate: np.ndarray, times: np.ndarray, roundoff: float) -> _Misses:
    """Compare; a slope is not known better than the rounding of what it is taken of."""
    apart = times[1] - times[0]
    slope, rougher = (_slope(x, weights) / apart for weights in (EIGHTH, SIXTH))
    inner = rate[WIDTH : len(rate) - WIDTH]
    miss, unsure = (np.abs(slope - other).reshape(len(slope), -1).max(axis=1) for other in (inner, rougher))
    rounding = roundoff * float(np.abs(x).max()) / apart
    return _Misses(miss, unsure + rounding, max(float(np.abs(slope).max()), float(np.abs(inner).max())))


def _slope(x: np.ndarray, weights: tuple[float, ...]) -> np.ndarray:
    n = len(x) - 2 * WIDTH
    pairs = (w * (x[WIDTH + k : WIDTH + k + n] - x[WIDTH - k : WIDTH - k + n]) for k, w in enumerate(weights, start=1))
    return np.sum(list(pairs), axis=0)


def energy_miss(scene: Scene, path: Trajectory) -> float | None:
    """Return the largest |E(t) - E(0) - work| over the largest kinetic energy; None where no balance can be drawn."""
    balance = energy_balance(scene, path)
    if balance.drift is None or balance.resolution > 0.0:  # work is integrated over the samples: too rough here
        return None
    scale = float(kinetic_energy(scene, path).max())
    return float(np.abs(balance.drift).max()) / scale if scale else None


def joint_gap(question: Asked, path: Trajectory) -> float | None:
    """Return the largest |C| (m over the scene's size, rad); None where there is no joint."""
    if not question.scene.joints:
        return None
    return float(np.abs(constraint_residual(question.scene, path)).max()) / size(question)
