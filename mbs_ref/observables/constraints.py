"""Constraint residuals C(q, t) and their rates, joint by joint, from world poses and velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.joint_rows import RESIDUALS, norm_row
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.trajectory import Trajectory


@dataclass(frozen=True)
class Rows:
    """Every constraint row of a scene along a motion."""

    joints: tuple[str, ...]  # (n_rows,) the joint each row belongs to; a body for the norm of its Euler parameters
    residual: np.ndarray  # (n_t, n_rows) m or rad
    rate: np.ndarray  # (n_t, n_rows) m/s or rad/s


def rows(scene: Scene, trajectory: Trajectory) -> Rows:
    """Evaluate C and dC/dt of every joint at every sample; references are the poses at t = 0 in the scene."""
    if not scene.joints:
        return Rows((), *np.zeros((2, len(trajectory.times), 0)))
    motion = Motion(scene, trajectory)
    rigid = [k for k, body in enumerate(scene.bodies) if isinstance(body, SpatialBody)]
    by_part = [(scene.bodies[k].name, [norm_row(trajectory.orientation[:, k])]) for k in rigid]
    by_part += [(joint.name, RESIDUALS[type(joint)](motion, joint)) for joint in scene.joints]
    names = tuple(name for name, part in by_part for _ in part)
    columns = [row for _, part in by_part for row in part]
    residual, rate = (np.stack(part, axis=1) for part in zip(*columns, strict=True))
    return Rows(names, residual, rate)


def constraint_residual(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return C(q, t), shape (n_t, n_rows): m for rows of length, rad for rows of angle."""
    return rows(scene, trajectory).residual


def constraint_rate(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return dC/dt = Cq v + Ct, shape (n_t, n_rows): m/s or rad/s."""
    return rows(scene, trajectory).rate
