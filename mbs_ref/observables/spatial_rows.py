"""Constraint residuals of spatial joints and their rates, from world poses and velocities."""

from __future__ import annotations

import numpy as np

from mbs_ref.observables.attachment import Motion, perpendiculars
from mbs_ref.observables.signal_values import motion as prescribed
from mbs_ref.scene import (
    CoordinateDrive,
    Cylindrical,
    Distance,
    PointDrive,
    PointOnPlane,
    Prismatic,
    Revolute,
    RotationDrive,
    Spherical,
    Universal,
    Weld,
)

Row = tuple[np.ndarray, np.ndarray]  # residual and rate, each (n_t,)


def norm_row(theta: np.ndarray) -> Row:
    """theta^T theta - 1 = 0 (Fox 1999, appendix); poses carry no parameter rates, so its rate is not judged."""
    return np.sum(theta**2, axis=1) - 1.0, np.zeros(len(theta))


def _dot(first: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]) -> Row:
    """Return the product of two moving vectors, and its rate."""
    (e, e_rate), (f, f_rate) = first, second
    return np.sum(e * f, axis=1), np.sum(e_rate * f + e * f_rate, axis=1)


def _separation(motion: Motion, joint, point_a, point_b) -> tuple[np.ndarray, np.ndarray]:
    (a, a_rate), (b, b_rate) = motion.point(joint.body_a, point_a), motion.point(joint.body_b, point_b)
    return b - a, b_rate - a_rate


def _coincidence(motion: Motion, joint) -> list[Row]:
    gap, rate = _separation(motion, joint, joint.point, joint.point)
    return [(gap[:, k], rate[:, k]) for k in range(3)]


def _parallel(motion: Motion, joint) -> list[Row]:
    """The axis in b stays across two normals in a: sines of angles."""
    axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
    there = motion.direction(joint.body_b, axis)
    return [_dot(motion.direction(joint.body_a, normal), there) for normal in perpendiculars(axis)]


def _locked(motion: Motion, joint) -> list[Row]:
    """x . y = y . z = z . x = 0 of axes in a and in b, which are one frame at t = 0."""
    here, there = ([motion.direction(body, e) for e in np.eye(3)] for body in (joint.body_a, joint.body_b))
    return [_dot(here[k], there[(k + 1) % 3]) for k in range(3)]


def _across(motion: Motion, joint, normals) -> list[Row]:
    gap = _separation(motion, joint, joint.point, joint.point)
    return [_dot(motion.direction(joint.body_a, normal), gap) for normal in normals]


def _revolute(motion: Motion, joint: Revolute) -> list[Row]:
    return [*_coincidence(motion, joint), *_parallel(motion, joint)]


def _universal(motion: Motion, joint: Universal) -> list[Row]:
    first, second = (np.asarray(axis) / np.linalg.norm(axis) for axis in (joint.axis_a, joint.axis_b))
    product = _dot(motion.direction(joint.body_a, first), motion.direction(joint.body_b, second))
    return [*_coincidence(motion, joint), product]


def _cylindrical(motion: Motion, joint: Cylindrical) -> list[Row]:
    return [*_across(motion, joint, perpendiculars(joint.axis)), *_parallel(motion, joint)]


def _prismatic(motion: Motion, joint: Prismatic) -> list[Row]:
    return [*_across(motion, joint, perpendiculars(joint.axis)), *_locked(motion, joint)]


def _weld(motion: Motion, joint: Weld) -> list[Row]:
    return [*_coincidence(motion, joint), *_locked(motion, joint)]


def _distance(motion: Motion, joint: Distance) -> list[Row]:
    gap, rate = _separation(motion, joint, joint.point_a, joint.point_b)
    length = np.linalg.norm(gap, axis=1)
    initial = float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
    along = np.divide(gap, length[:, None], out=np.zeros_like(gap), where=length[:, None] > 0.0)
    return [(length - (initial if joint.length is None else joint.length), np.sum(along * rate, axis=1))]


def _point_on_plane(motion: Motion, joint: PointOnPlane) -> list[Row]:
    return _across(motion, joint, [np.asarray(joint.normal) / np.linalg.norm(joint.normal)])


def _rotation_drive(motion: Motion, joint: RotationDrive) -> list[Row]:
    asked, asked_rate = prescribed(joint.motion, joint.level, motion.times)
    angle, rate = motion.angle_about(joint.body_a, joint.body_b, joint.axis)
    return [(np.remainder(angle - asked + np.pi, 2.0 * np.pi) - np.pi, rate - asked_rate)]


def _coordinate_drive(motion: Motion, joint: CoordinateDrive) -> list[Row]:
    asked, asked_rate = prescribed(joint.motion, joint.level, motion.times)
    k, axis = motion.scene.body_index(joint.body), "xyz".index(joint.coordinate)
    moved = motion.trajectory.position[:, k, axis] - motion.scene.bodies[k].position[axis]
    return [(moved - asked, motion.trajectory.velocity[:, k, axis] - asked_rate)]


def _point_drive(motion: Motion, joint: PointDrive) -> list[Row]:
    asked, asked_rate = prescribed(joint.motion, joint.level, motion.times)
    place, rate = motion.point(joint.body, joint.point)
    along = np.asarray(joint.direction) / np.linalg.norm(joint.direction)
    return [((place - np.asarray(joint.point)) @ along - asked, rate @ along - asked_rate)]


SPATIAL_ROWS = {
    Spherical: _coincidence,
    Revolute: _revolute,
    Universal: _universal,
    Cylindrical: _cylindrical,
    Prismatic: _prismatic,
    Weld: _weld,
    Distance: _distance,
    PointOnPlane: _point_on_plane,
    RotationDrive: _rotation_drive,
    CoordinateDrive: _coordinate_drive,
    PointDrive: _point_drive,
}
