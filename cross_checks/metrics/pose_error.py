"""Distance of the bodies from where they should be."""

from __future__ import annotations

import numpy as np

from cross_checks.metrics.orientation_error import orientation_error
from cross_checks.truths import Truth
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.trajectory import Trajectory


def pose_error(scene: Scene, trajectory: Trajectory, truth: Truth) -> np.ndarray:
    """Return the largest distance over bodies of world points from the truth (n_t,), m.

    The points are the centres of mass and, in space, also points one radius of gyration away: a body that
    turns about a centre at rest is elsewhere too. The samples that both reached are compared.
    """
    centres = distance(trajectory.position, truth.position)
    if not any(isinstance(body, SpatialBody) for body in scene.bodies):
        return centres
    return np.maximum(centres, np.max(orientation_error(trajectory, truth) * arms(scene), axis=1))


def arms(scene: Scene) -> np.ndarray:
    """Return each body's largest radius of gyration in space (n_bodies,), m; zero for others."""
    return np.array([body.gyration_radius if isinstance(body, SpatialBody) else 0.0 for body in scene.bodies])


def distance(position: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the largest distance over bodies (n_t,), m, of two sets of world points over their common samples."""
    n = min(len(position), len(other))
    return np.max(np.linalg.norm(position[:n] - other[:n], axis=2), axis=1)
