"""Constraint residuals C(q, t) and their rates, joint by joint, from world poses and velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbs_ref.observables.attachment import PERP, Motion
from mbs_ref.observables.signal_values import motion as prescribed
from mbs_ref.observables.spatial_rows import SPATIAL_ROWS, norm_row
from mbs_ref.scene import CoordinateDrive, Distance, PointDrive, Prismatic, Revolute, Scene, SpatialBody, Weld
from mbs_ref.scene.euler_parameters import floats
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
    names: list[str] = []
    columns: list[tuple[np.ndarray, np.ndarray]] = []
    table = ROWS if scene.dimension == 2 else SPATIAL_ROWS
    for k, body in enumerate(scene.bodies):
        if isinstance(body, SpatialBody):
            columns.append(norm_row(trajectory.orientation[:, k]))
            names.append(body.name)
    for joint in scene.joints:
        found = table[type(joint)](motion, joint)
        columns += found
        names += [joint.name] * len(found)
    if not columns:
        empty = np.zeros((len(trajectory.times), 0))
        return Rows((), empty, empty)
    residual, rate = (np.stack(part, axis=1) for part in zip(*columns, strict=True))
    return Rows(tuple(names), residual, rate)


def constraint_residual(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return C(q, t), shape (n_t, n_rows): m for rows of length, rad for rows of angle."""
    return rows(scene, trajectory).residual


def constraint_rate(scene: Scene, trajectory: Trajectory) -> np.ndarray:
    """Return dC/dt = Cq v + Ct, shape (n_t, n_rows): m/s or rad/s."""
    return rows(scene, trajectory).rate


Row = tuple[np.ndarray, np.ndarray]  # residual and rate, each (n_t,)


def _coincidence(motion: Motion, joint) -> list[Row]:
    """p_b - p_a = 0 (Fox 1999 eq 5)."""
    (a, a_rate), (b, b_rate) = motion.point(joint.body_a, joint.point), motion.point(joint.body_b, joint.point)
    return [(b[:, k] - a[:, k], b_rate[:, k] - a_rate[:, k]) for k in range(2)]


def _no_turning(motion: Motion, joint) -> Row:
    turned = motion.angle(joint.body_b) - motion.angle(joint.body_a)
    return wrapped(turned), motion.spin(joint.body_b) - motion.spin(joint.body_a)


def _revolute(motion: Motion, joint: Revolute) -> list[Row]:
    return _coincidence(motion, joint)


def _weld(motion: Motion, joint: Weld) -> list[Row]:
    return [*_coincidence(motion, joint), _no_turning(motion, joint)]


def _prismatic(motion: Motion, joint: Prismatic) -> list[Row]:
    """n . (p_b - p_a) = 0 with n normal to the axis in body a, and no relative turning."""
    normal, normal_rate = motion.direction(joint.body_a, PERP @ unit(joint.axis))
    (a, a_rate), (b, b_rate) = motion.point(joint.body_a, joint.point), motion.point(joint.body_b, joint.point)
    across = np.sum(normal * (b - a), axis=1)
    rate = np.sum(normal_rate * (b - a) + normal * (b_rate - a_rate), axis=1)
    return [(across, rate), _no_turning(motion, joint)]


def _distance(motion: Motion, joint: Distance) -> list[Row]:
    """|p_b - p_a| - l = 0, in metres."""
    (a, a_rate), (b, b_rate) = motion.point(joint.body_a, joint.point_a), motion.point(joint.body_b, joint.point_b)
    gap, gap_rate = b - a, b_rate - a_rate
    length = np.linalg.norm(gap, axis=1)
    initial = float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
    nominal = joint.length if joint.length is not None else initial
    along = np.divide(gap, length[:, None], out=np.zeros_like(gap), where=length[:, None] > 0.0)
    return [(length - nominal, np.sum(along * gap_rate, axis=1))]


def _coordinate_drive(motion: Motion, joint: CoordinateDrive) -> list[Row]:
    asked, asked_rate = prescribed(joint.motion, joint.level, motion.times)
    if joint.coordinate == "angle":
        return [(wrapped(motion.angle(joint.body) - asked), motion.spin(joint.body) - asked_rate)]
    k, axis = motion.scene.body_index(joint.body), "xy".index(joint.coordinate)
    moved = motion.trajectory.position[:, k, axis] - motion.scene.bodies[k].position[axis]
    return [(moved - asked, motion.trajectory.velocity[:, k, axis] - asked_rate)]


def _point_drive(motion: Motion, joint: PointDrive) -> list[Row]:
    asked, asked_rate = prescribed(joint.motion, joint.level, motion.times)
    place, rate = motion.point(joint.body, joint.point)
    along = unit(joint.direction)
    return [((place - np.asarray(joint.point)) @ along - asked, rate @ along - asked_rate)]


ROWS = {
    Revolute: _revolute,
    Prismatic: _prismatic,
    Weld: _weld,
    Distance: _distance,
    CoordinateDrive: _coordinate_drive,
    PointDrive: _point_drive,
}


def unit(vector) -> np.ndarray:
    """Return the vector at length one."""
    return floats(vector) / np.linalg.norm(floats(vector))


def wrapped(angle: np.ndarray) -> np.ndarray:
    """Return the angle in [-pi, pi]: a full turn is no violation."""
    return np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
