"""Constraint residuals C(q, t) of every joint and their rates, from world poses and velocities.

They follow from the definition of a joint, not from its rows in the solver (mbs_ref/scene/base/rows.py), so that
a joint with wrong rows is detected. Residuals are lengths (m), angles (rad) or sines of angles.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbs_ref.observables.attachment import PERP, Motion, length_of, perpendiculars
from mbs_ref.scene import Scene, SpatialBody, joints
from mbs_ref.scene.base.part import unit
from mbs_ref.scene.euler_parameters import from_axis_angle, product, rotation_matrices
from mbs_ref.scene.signals import prescribed
from mbs_ref.trajectory import Trajectory

Row = tuple[np.ndarray, np.ndarray]  # residual and rate, each (n_t,)
RATE_STEP = 1e-3  # m or rad of the motion: truncation h^4 and roundoff eps / h of a rate are alike, 1e-12 of size one
Vectors = tuple[np.ndarray, np.ndarray]  # a moving vector and its rate, each (n_t, dimension)


def _turned(row: Row) -> list[Row]:
    """Return the row with its angle in [-pi, pi]: a full turn is no violation."""
    return [(np.remainder(row[0] + np.pi, 2.0 * np.pi) - np.pi, row[1])]


def _dot(first: Vectors, second: Vectors) -> Row:
    """Return the product of two moving vectors, and its rate."""
    (e, e_rate), (f, f_rate) = first, second
    return np.sum(e * f, axis=1), np.sum(e_rate * f + e * f_rate, axis=1)


def _separation(motion: Motion, joint) -> Vectors:
    """Return how far body b's point is from body a's that was there at t = 0, and its rate."""
    (a, a_rate), (b, b_rate) = (motion.point(body, joint.point) for body in joint.ends)
    return b - a, b_rate - a_rate


def coincidence(motion: Motion, joint) -> list[Row]:
    """p_b - p_a = 0 (Fox 1999 eq 5)."""
    gap, rate = _separation(motion, joint)
    return [(gap[:, k], rate[:, k]) for k in range(gap.shape[1])]


def parallel(motion: Motion, joint, axis) -> list[Row]:
    """The axis in b stays across two normals in a."""
    there = motion.direction(joint.body_b, unit(axis))
    return [_dot(motion.direction(joint.body_a, normal), there) for normal in perpendiculars(axis)]


def across(motion: Motion, joint, normals) -> list[Row]:
    """n . (p_b - p_a) = 0 with normals n fixed in a."""
    gap = _separation(motion, joint)
    return [_dot(motion.direction(joint.body_a, normal), gap) for normal in normals]


def no_turning(motion: Motion, joint) -> list[Row]:
    """In the plane the relative angle; in space x . y = y . z = z . x = 0 of axes in a and in b, one frame at t = 0."""
    if motion.scene.dimension == 2:
        turned = motion.angle(joint.body_b) - motion.angle(joint.body_a)
        return _turned((turned, motion.turning(joint.body_b) - motion.turning(joint.body_a)))
    here, there = ([motion.direction(body, e) for e in np.eye(3)] for body in (joint.body_a, joint.body_b))
    return [_dot(here[k], there[(k + 1) % 3]) for k in range(3)]


def _universal(motion: Motion, joint: joints.Universal) -> list[Row]:
    first, second = unit(joint.axis_a), unit(joint.axis_b)
    product = _dot(motion.direction(joint.body_a, first), motion.direction(joint.body_b, second))
    return [*coincidence(motion, joint), product]


def _prismatic(motion: Motion, joint: joints.Prismatic) -> list[Row]:
    normals = perpendiculars(joint.axis) if len(joint.axis) == 3 else [PERP @ unit(joint.axis)]
    return [*across(motion, joint, normals), *no_turning(motion, joint)]


def _driven(motion: Motion, joint: joints.Drive, moved: np.ndarray, rate: np.ndarray) -> Row:
    """Return by how much a displacement since t = 0 is beyond the prescribed one."""
    prescribed_value, motion_rate = prescribed(joint.motion, joint.level, motion.times)
    return moved - prescribed_value, rate - motion_rate


def _rolling_wheel(motion: Motion, joint: joints.RollingWheel) -> list[Row]:
    """The lowest point of the rim is at the plane's height, and the wheel's matter there is at rest.

    The wheel's plane cuts the ground's along a x n; of the rim the point across that line is the lowest.
    """
    normal = unit(joint.normal)
    axis, (centre, _) = motion.direction(joint.body, unit(joint.axis))[0], motion.point(joint.body, joint.point)
    level = np.cross(axis, normal)
    lowest = centre + joint.radius * np.cross(axis, level / np.linalg.norm(level, axis=1, keepdims=True))
    at_first = np.add(joint.point, joint.radius * np.cross(unit(joint.axis), unit(np.cross(joint.axis, normal))))
    slip = motion.rate_at(joint.body, lowest)
    along = [(np.zeros(len(slip)), slip @ edge) for edge in perpendiculars(normal)]
    return [*along, ((lowest - at_first) @ normal, slip @ normal)]


def _coordinate_drive(motion: Motion, joint: joints.CoordinateDrive) -> list[Row]:
    if joint.coordinate == "angle":
        return _turned(_driven(motion, joint, motion.angle(joint.body), motion.turning(joint.body)))
    k, axis = motion.scene.body_index(joint.body), "xyz".index(joint.coordinate)
    moved = motion.trajectory.position[:, k, axis] - motion.scene.bodies[k].position[axis]
    return [_driven(motion, joint, moved, motion.trajectory.velocity[:, k, axis])]


def _point_drive(motion: Motion, joint: joints.PointDrive) -> list[Row]:
    (place, rate), along = motion.point(joint.body, joint.point), unit(joint.direction)
    return [_driven(motion, joint, (place - np.asarray(joint.point)) @ along, rate @ along)]


def _user_constraint(motion: Motion, joint: joints.UserConstraint) -> list[Row]:
    """C itself at the poses; its rate by differences of fourth order along the velocities."""
    formula = joint.formula()

    def value(k: int, ahead: float) -> float:
        places = [_place(motion, *end, k, ahead) for end in zip(joint.ends, joint.marks, strict=True)]
        return float(formula(float(motion.times[k]) + ahead, *places))

    rate = []
    for k in range(len(motion.times)):
        step = RATE_STEP / max(1.0, *(float(np.abs(x[k]).max()) for x in _rates(motion, joint)))
        near = {s: value(k, s * step) for s in (-2, -1, 1, 2)}
        rate.append((8.0 * (near[1] - near[-1]) - (near[2] - near[-2])) / (12.0 * step))
    return [(np.array([value(k, 0.0) for k in range(len(motion.times))]), np.array(rate))]


def _rates(motion: Motion, joint) -> list[np.ndarray]:
    """Return the rates (n_t, ...) of both ends."""
    indices = [motion.scene.body_index(end) for end in joint.ends]
    path = motion.trajectory
    return [part[:, k].reshape(len(motion.times), -1) for k in indices if k >= 0
            for part in (path.velocity, path.angular_velocity)]  # fmt: skip


def _place(motion: Motion, body: str, mark, k: int, ahead: float):
    """Return an end's place at sample k, moved on for `ahead` (s) at the velocities there."""
    scene, path, index = motion.scene, motion.trajectory, motion.scene.body_index(body)
    place: Any = joints.PLACES[scene.dimension]
    if index < 0:
        origin = (0.0,) * scene.dimension if mark is None else mark
        return place(*origin, *np.ravel(scene.world.unturned).tolist())
    start: Any = scene.bodies[index]
    arm = np.zeros(scene.dimension) if mark is None else np.subtract(mark, start.position)
    centre = path.position[k, index] + ahead * path.velocity[k, index]
    spin, turned = path.angular_velocity[k, index], path.orientation[k, index]
    if place is joints.PlanarPlace:
        now = turned + ahead * spin
        since = now - getattr(start, "angle", 0.0)
        return place(*(centre + np.cos(since) * arm + np.sin(since) * (PERP @ arm)), now)
    speed = np.linalg.norm(spin)
    now = turned if speed == 0.0 else product(from_axis_angle(spin, ahead * speed), turned)
    first = rotation_matrices(getattr(start, "orientation", (1.0, 0.0, 0.0, 0.0)))
    return place(*(centre + rotation_matrices(now) @ first.T @ arm), *now)


RESIDUALS: dict[type[joints.JointPart], Callable[[Motion, Any], list[Row]]] = {
    joints.Revolute: lambda m, j: [*coincidence(m, j), *(parallel(m, j, j.axis) if j.axis else ())],
    joints.Spherical: coincidence, joints.Universal: _universal,
    joints.Cylindrical: lambda m, j: [*across(m, j, perpendiculars(j.axis)), *parallel(m, j, j.axis)],
    joints.Prismatic: _prismatic, joints.Weld: lambda m, j: [*coincidence(m, j), *no_turning(m, j)],
    joints.Distance: lambda m, j: [length_of(m, j)[1:]], joints.RollingWheel: _rolling_wheel,
    joints.PointOnPlane: lambda m, j: across(m, j, [unit(j.normal)]),
    joints.RotationDrive: lambda m, j: _turned(_driven(m, j, *m.angle_about(j.body_a, j.body_b, j.axis))),
    joints.CoordinateDrive: _coordinate_drive, joints.PointDrive: _point_drive, joints.UserConstraint: _user_constraint,
}  # fmt: skip


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
    # theta^T theta - 1 = 0 (Fox 1999, appendix); poses carry no parameter rates, so its rate is not judged
    turns, still = trajectory.orientation, np.zeros(len(trajectory.times))
    by_part = [
        (body.name, [(np.sum(turns[:, k] ** 2, axis=1) - 1.0, still)])
        for k, body in enumerate(scene.bodies)
        if isinstance(body, SpatialBody)
    ]
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
