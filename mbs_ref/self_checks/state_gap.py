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
    """Return the largest differences over bodies (n_t, 4) at the same times; infinite where not finite.

    Whole turns in the plane do not count.
    """
    with np.errstate(all="ignore"):
        gaps = np.stack([
            np.linalg.norm(first.position - second.position, axis=2) / scales.length,
            _turned(first.orientation, second.orientation) * _turning(scene),
            np.linalg.norm(first.velocity - second.velocity, axis=2) / scales.speed,
            _lengths(first.angular_velocity - second.angular_velocity) * _turning(scene) * scales.time,
        ], axis=1)  # fmt: skip
    return np.max(np.where(np.isfinite(gaps), gaps, np.inf), axis=2)


def state_sizes(scene: Scene, scales: Scales, run: Poses, times: np.ndarray) -> np.ndarray:
    """Return how far a run goes from its start in position and orientation, and its largest rates (4,).

    Where outputs show bodies near their start alone, as once a period, the distance between them is taken that their
    speeds may cover.
    """
    gone = state_gaps(scene, scales, run, Poses(*(part[:1] for part in run)))
    speeds = np.linalg.norm(run.velocity, axis=2).max(axis=1)
    way = min(float(np.nansum(np.diff(times) * speeds[1:])), _extent(run)) / scales.length
    spins = _lengths(run.angular_velocity) * _turning(scene) * scales.time
    return np.array([
        max(_finite_max(gone[:, 0]), way), _finite_max(gone[:, 1]), _finite_max(speeds) / scales.speed,
        _finite_max(spins),
    ])  # fmt: skip


def coordinate_size(scales: Scales, run: Poses) -> float:
    """Return the largest coordinate over the scene's length, at least 1: what a relative tolerance is relative to."""
    return max(_finite_max(np.abs(run.position)) / scales.length, 1.0)


def _turned(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the angle between orientations (n_t, n_bodies), rad in [0, pi]."""
    if first.ndim == 3:
        return geodesic_angle(first, second)
    return np.abs(np.remainder(first - second + np.pi, 2.0 * np.pi) - np.pi)


def _turning(scene: Scene) -> np.ndarray:
    """Return 1 for every body that has an orientation, 0 for particles (n_bodies,)."""
    return np.array([0.0 if isinstance(body, PointMass) else 1.0 for body in scene.bodies])


def _lengths(rates: np.ndarray) -> np.ndarray:
    return np.abs(rates) if rates.ndim == 2 else np.linalg.norm(rates, axis=2)


def _extent(run: Poses) -> float:
    """Return the diagonal (m) of the box around all bodies at all times."""
    places = run.position.reshape(-1, run.position.shape[2])
    places = places[np.isfinite(places).all(axis=1)]
    return float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0


def _finite_max(values: np.ndarray) -> float:
    return float(np.max(values, where=np.isfinite(values), initial=0.0))
