"""How far are two runs apart, and how far does a motion go? In position, orientation and their rates.

Every component counts over the scene's own scales: metres over its length L, radians as they are, m/s over L/T and
rad/s over 1/T. Truths judge errors by the same quantity.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.euler_parameters import geodesic_angle
from mbs_ref.scene.scales import Scales


def state_gaps(scene: Scene, scales: Scales, first: Poses, second: Poses) -> np.ndarray:
    """Return the largest differences over bodies (..., n_t, 4) at the same times; infinite where not finite.

    Whole turns in the plane do not count. Poses may be those of one run, or of several runs (n_runs, n_t, ...).
    """
    with np.errstate(all="ignore"):
        gaps = np.stack([
            *_pose_gaps(scene, scales, first, second),
            np.linalg.norm(first.velocity - second.velocity, axis=-1) / scales.speed,
            _spins(scene, first, second) * scales.time,
        ])  # fmt: skip
    return np.moveaxis(np.max(np.where(np.isfinite(gaps), gaps, np.inf), axis=-1), 0, -1)


def _pose_gaps(scene: Scene, scales: Scales, first: Poses, second: Poses) -> tuple[np.ndarray, np.ndarray]:
    """Return how far bodies are apart (..., n_t, n_bodies) in position and orientation."""
    return (
        np.linalg.norm(first.position - second.position, axis=-1) / scales.length,
        _turned(first, second) * _turning(scene),
    )


def state_sizes(scene: Scene, scales: Scales, run: Poses, times: np.ndarray) -> np.ndarray:
    """Return how far a run goes from its start in position and orientation, and its largest rates (..., 4).

    Where outputs show bodies near their start alone, as once a period, the distance between them is taken that their
    speeds may cover.
    """
    with np.errstate(all="ignore"):
        gone = [_finite_max(gaps.max(axis=-1), 1) for gaps in _pose_gaps(scene, scales, run, _start_of(run))]
    speeds = np.linalg.norm(run.velocity, axis=-1).max(axis=-1)
    way = np.minimum(np.nansum(np.diff(times) * speeds[..., 1:], axis=-1), _extent(run)) / scales.length
    rates = _finite_max(speeds, 1) / scales.speed, _finite_max(_spins(scene, run) * scales.time, 2)
    return np.stack((np.maximum(gone[0], way), gone[1], *rates), axis=-1)


def coordinate_size(scales: Scales, run: Poses) -> float:
    """Return the largest coordinate over the scene's length, at least 1: what a relative tolerance is relative to."""
    return max(float(_finite_max(np.abs(run.position), 3)) / scales.length, 1.0)


def _is_planar(run: Poses) -> bool:
    return run.orientation.ndim < run.position.ndim


def _start_of(run: Poses) -> Poses:
    """Return the first sample, with its axis."""
    first = (slice(None),) * (run.position.ndim - 3) + (slice(1),)
    return Poses(*(part[first] for part in run))


def _turned(first: Poses, second: Poses) -> np.ndarray:
    """Return the angle between orientations (..., n_t, n_bodies), rad in [0, pi]."""
    if not _is_planar(first):
        return geodesic_angle(first.orientation, second.orientation)
    return np.abs(np.remainder(first.orientation - second.orientation + np.pi, 2.0 * np.pi) - np.pi)


def _turning(scene: Scene) -> np.ndarray:
    """Return 1 for every body that has an orientation, 0 for particles (n_bodies,)."""
    return np.array([0.0 if isinstance(body, PointMass) else 1.0 for body in scene.bodies])


def _spins(scene: Scene, run: Poses, other: Poses | None = None) -> np.ndarray:
    """Return the size of the angular velocities (..., n_t, n_bodies), or of their differences, rad/s."""
    rates = run.angular_velocity - (0.0 if other is None else other.angular_velocity)
    return (np.abs(rates) if _is_planar(run) else np.linalg.norm(rates, axis=-1)) * _turning(scene)


def _extent(run: Poses) -> np.ndarray:
    """Return the diagonal (..., m) of the box around all bodies at all times."""
    places = run.position
    known = np.isfinite(places).all(axis=-1, keepdims=True)
    low = np.min(places, axis=(-3, -2), where=known, initial=np.inf)
    high = np.max(places, axis=(-3, -2), where=known, initial=-np.inf)
    return np.linalg.norm(np.maximum(high - low, 0.0), axis=-1)


def _finite_max(values: np.ndarray, axes: int) -> np.ndarray:
    """Return the largest finite number over the last axes, 0 where there is none."""
    return np.max(values, axis=tuple(range(-axes, 0)), where=np.isfinite(values), initial=0.0)
