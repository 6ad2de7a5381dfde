"""How far are the poses of two runs apart, and how far does a motion go? In metres, of world points.

The points are each body's centre of mass and those one radius of gyration away from it: a body that turns about a
centre at rest is elsewhere too. Truths judge errors by the same quantity.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene
from mbs_ref.scene.euler_parameters import geodesic_angle


def pose_gap(scene: Scene, first: Poses, second: Poses) -> np.ndarray:
    """Return the largest distance over bodies (n_t,), m, between poses at the same times; infinite where not finite.

    Angles in the plane count whole turns.
    """
    return _farthest(scene, first, second, np.inf)


def motion_size(scene: Scene, run: Poses, times: np.ndarray) -> float:
    """Return how far a run goes (m) from its start; a body's turn counts up to half of one.

    Where outputs show it near its start alone, as once a period, the distance between bodies is taken that their
    speeds may cover.
    """
    start = Poses(*(part[:1] for part in run))
    gone = _finite_max(_farthest(scene, run, start, np.pi))
    way = float(np.sum(np.diff(times) * _speed(run)[1:])) if len(times) > 1 else 0.0
    return max(gone, min(way, _extent(run)))


def coordinate_size(scene: Scene, run: Poses) -> float:
    """Return the largest coordinate or radius of gyration (m): what a relative tolerance is relative to."""
    return max(_finite_max(np.abs(run.position)), float(np.max(_arms(scene))))


def _farthest(scene: Scene, first: Poses, second: Poses, most: float) -> np.ndarray:
    planar = first.orientation.ndim == 2
    with np.errstate(all="ignore"):
        centres = np.linalg.norm(first.position - second.position, axis=2)
        turned = np.abs(first.orientation - second.orientation) if planar else geodesic_angle(
            first.orientation, second.orientation
        )
        gaps = np.maximum(centres, np.minimum(turned, most) * _arms(scene))
    return np.max(np.where(np.isfinite(gaps), gaps, np.inf), axis=1)


def _arms(scene: Scene) -> np.ndarray:
    return np.array([body.gyration_radius for body in scene.bodies])


def _speed(run: Poses) -> np.ndarray:
    speed = np.linalg.norm(run.velocity, axis=2).max(axis=1)
    return np.where(np.isfinite(speed), speed, 0.0)


def _extent(run: Poses) -> float:
    """Return the diagonal (m) of the box around all bodies at all times."""
    places = run.position.reshape(-1, run.position.shape[2])
    places = places[np.isfinite(places).all(axis=1)]
    return float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0


def _finite_max(values: np.ndarray) -> float:
    return float(np.max(values, where=np.isfinite(values), initial=0.0))
