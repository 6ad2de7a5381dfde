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
    x, v, own = trajectory.position, trajectory.velocity, spins(scene, trajectory).sum(axis=1)
    moments = np.cross(x, v) if x.shape[2] == 3 else x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0]
    return np.einsum("k,tk...->t...", mass, moments) + own


def spins(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return J omega of every body about its centre of mass, like angular velocities; kg m^2/s, 0 for particles."""
    result = np.zeros_like(trajectory.angular_velocity)
    for k, body in enumerate(scene.bodies):
        omega = trajectory.angular_velocity[:, k]
        if isinstance(body, PlanarBody):
            result[:, k] = body.inertia * omega
        elif isinstance(body, SpatialBody):
            turned = rotation_matrices(trajectory.orientation[:, k])
            result[:, k] = np.einsum("tij,jk,tlk,tl->ti", turned, body.inertia_matrix, turned, omega, optimize=True)
    return result


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
