"""Linear and angular momentum, and how far their conserved parts drift."""

from __future__ import annotations

import numpy as np

from mbs_ref.scene import GROUND, Bushing, PlanarBody, Scene, SpringDamper, TorsionSpring
from mbs_ref.traits import joint_ends
from mbs_ref.trajectory import Trajectory


def linear_momentum(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return the linear momentum (n_t, 2), kg m/s."""
    mass = np.array([body.mass for body in scene.bodies])
    return np.einsum("k,tkd->td", mass, trajectory.velocity)


def angular_momentum(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return the angular momentum about the world origin (n_t,), kg m^2/s."""
    mass = np.array([body.mass for body in scene.bodies])
    inertia = np.array([body.inertia if isinstance(body, PlanarBody) else 0.0 for body in scene.bodies])
    rigid = inertia > 0.0
    (x, y), (vx, vy) = np.moveaxis(trajectory.position, 2, 0), np.moveaxis(trajectory.velocity, 2, 0)
    return (x * vy - y * vx) @ mass + trajectory.angular_velocity[:, rigid] @ inertia[rigid]


def momentum_drift(scene: Scene, trajectory: Trajectory) -> np.ndarray | None:
    """Return the largest drift (n_t,) of what is conserved, kg m/s (kg m^2/s); None where nothing is.

    Without anything tied to ground and without outer loads, linear momentum across gravity is
    conserved, and all of linear and angular momentum where gravity is zero.
    """
    if _is_held(scene):
        return None
    gravity = np.asarray(scene.gravity)
    moved = linear_momentum(scene, trajectory) - linear_momentum(scene, trajectory)[0]
    if np.any(gravity):
        across = np.array([-gravity[1], gravity[0]]) / np.linalg.norm(gravity)
        return np.abs(moved @ across)
    turned = angular_momentum(scene, trajectory)
    return np.maximum(np.max(np.abs(moved), axis=1), np.abs(turned - turned[0]))


def _is_held(scene: Scene) -> bool:
    inner = (SpringDamper, TorsionSpring, Bushing)
    if any(GROUND in joint_ends(joint) for joint in scene.joints):
        return True
    if any(GROUND in (contact.body_a, contact.body_b) for contact in scene.contacts):
        return True
    return any(not isinstance(load, inner) or GROUND in (load.body_a, load.body_b) for load in scene.loads)
