"""Loads in space for tree mechanisms of other engines, by our own force code: then dynamics is what is compared."""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.spatial.system import SpatialSystem
from mbs_ref.scene import Scene, SpatialBody, symmetric
from mbs_ref.scene.euler_parameters import rotation_matrices


class SpatialApplied:
    """Forces and torques on the bodies of a scene, gravity included."""

    def __init__(self, scene: Scene) -> None:
        self.system = SpatialSystem(scene)
        self.start = self.system.initial_state()
        self.rigid = {k: b for k, b in enumerate(scene.bodies) if isinstance(b, SpatialBody)}

    def on_bodies(self, t: float, position, theta, velocity, omega) -> np.ndarray:
        """Return force and torque about the centre of mass (n_bodies, 6) at world poses: N, N m, world axes."""
        y = self.start.copy()
        bodies = self.system.groups.bodies
        axes = rotation_matrices(theta)
        for i, k in enumerate(bodies.scene_index):
            q, v = bodies.q[i], bodies.v[i]
            y[q : q + 3], y[v : v + 3] = position[k], velocity[k]
            if k in self.rigid:
                y[q + 3 : q + 7], y[v + 3 : v + 6] = theta[k], axes[k].T @ omega[k]
        self.system.set_mode_time(t)
        applied = self.system.applied_forces(t, y).copy()
        for k, body in self.rigid.items():  # the core counts the gyroscopic torque among them
            momentum = axes[k] @ symmetric(body.inertia) @ axes[k].T @ omega[k]
            applied[k, 3:] += np.cross(omega[k], momentum)
        return applied
