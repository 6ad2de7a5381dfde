"""Generalized external and constraint forces of every body along a motion (Fox 1999, Figs. 3 to 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbs_ref.cores.planar.system import PlanarSystem
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory


@dataclass(frozen=True)
class BodyForces:
    """Per body along a motion: N, N, N m, in the scene's body order."""

    external: np.ndarray  # (n_t, n_bodies, 3) Q_e: gravity, loads, contacts
    constraint: np.ndarray  # (n_t, n_bodies, 3) Q_c = -C_q^T lambda
    acceleration: np.ndarray  # (n_t, n_bodies, 3) m/s^2, m/s^2, rad/s^2


def body_forces(scene: Scene, trajectory: Trajectory) -> BodyForces:
    """Evaluate Q_e, and Q_c = M qdd - Q_e, at every sample of any engine's planar motion.

    Contact forces follow from the state alone: their laws must need no located events.
    """
    system = PlanarSystem(scene)
    q = np.concatenate((trajectory.position, trajectory.orientation[:, :, None]), axis=2)
    v = np.concatenate((trajectory.velocity, trajectory.angular_velocity[:, :, None]), axis=2)
    system.start_contacts(0.0, np.concatenate((q[0].ravel(), v[0].ravel())), located=False)
    external, acceleration = np.zeros_like(q), np.zeros_like(q)
    for k, t in enumerate(trajectory.times):
        system.set_mode_time(t)
        external[k] = system.applied_forces(t, q[k], v[k])
        dy = system.derivative(t, np.concatenate((q[k].ravel(), v[k].ravel())))
        acceleration[k] = dy[q[k].size :].reshape(-1, 3)
    constraint = system.mass_matrix().reshape(-1, 3) * acceleration - external
    return BodyForces(external, constraint, acceleration)
