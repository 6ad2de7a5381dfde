"""Linear and angular momentum, and how far their conserved parts drift."""

import numpy as np

from mbs_ref.observables import celestial
from mbs_ref.scene import GROUND, PlanarBody, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.scales import is_celestial
from mbs_ref.trajectory import Trajectory


def linear_momentum(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return the linear momentum (n_t, dimension), kg m/s."""
    mass = np.array([body.mass for body in scene.bodies])
    return np.einsum("k,tkd->td", mass, trajectory.velocity)


def angular_momentum(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return the angular momentum about the world origin (n_t,), or (n_t, 3) in space, kg m^2/s."""
    mass = np.array([body.mass for body in scene.bodies])
    if scene.dimension == 3:
        orbital = np.einsum("k,tkd->td", mass, np.cross(trajectory.position, trajectory.velocity))
        return orbital + _spatial_spin(scene, trajectory)
    inertia = np.array([body.inertia if isinstance(body, PlanarBody) else 0.0 for body in scene.bodies])
    rigid = inertia > 0.0
    (x, y), (vx, vy) = np.moveaxis(trajectory.position, 2, 0), np.moveaxis(trajectory.velocity, 2, 0)
    return (x * vy - y * vx) @ mass + trajectory.angular_velocity[:, rigid] @ inertia[rigid]


def _spatial_spin(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """A J A^T omega of every rigid body."""
    total = np.zeros((len(trajectory.times), 3))
    for k, body in enumerate(scene.bodies):
        if isinstance(body, SpatialBody):
            turned = rotation_matrices(trajectory.orientation[:, k])
            inertia = turned @ body.inertia_matrix @ np.swapaxes(turned, 1, 2)
            total += np.einsum("tij,tj->ti", inertia, trajectory.angular_velocity[:, k])
    return total


def momentum_drift(scene: Scene, trajectory: Trajectory) -> np.ndarray | None:
    """Return the largest drift (n_t,) of what is conserved, kg m/s (kg m^2/s); None where nothing is.

    Without anything tied to ground and without outer loads, linear momentum across gravity is
    conserved, and all of linear and angular momentum where gravity is zero.
    """
    if is_celestial(scene):
        return celestial.momentum_drift(scene, trajectory)
    if any(GROUND in part.ends for part in (*scene.joints, *scene.contacts, *scene.loads)):
        return None
    gravity = np.asarray(scene.gravity)
    moved = linear_momentum(scene, trajectory) - linear_momentum(scene, trajectory)[0]
    if np.any(gravity):
        down = gravity / np.linalg.norm(gravity)
        return np.max(np.abs(moved - np.outer(moved @ down, down)), axis=1)
    turned = angular_momentum(scene, trajectory).reshape(len(moved), -1)
    return np.maximum(np.max(np.abs(moved), axis=1), np.max(np.abs(turned - turned[0]), axis=1))
