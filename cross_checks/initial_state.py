"""Do the bodies' own poses and velocities at t = 0 satisfy every joint? Engines snap or drift silently if not."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cross_checks.joint_tree import turned
from cross_checks.prescribed import displacement
from mbs_ref.scene import CoordinateDrive, Distance, Joint, PlanarBody, PointDrive, Prismatic, Revolute, Scene


@dataclass(frozen=True)
class Gap:
    """How far a joint is from satisfied at t = 0."""

    joint: str
    position: float  # m or rad
    velocity: float  # m/s or rad/s


def gaps(scene: Scene) -> list[Gap]:
    """Return every joint's gap in a planar scene."""
    return [Gap(joint.name, *_gap(scene, joint)) for joint in scene.joints]


def inconsistency(scene: Scene, tolerance: float) -> str:
    """Return a sentence on the worst gap above the tolerance, or nothing."""
    worst = max(gaps(scene), key=lambda gap: max(gap.position, gap.velocity), default=None)
    if worst is None or max(worst.position, worst.velocity) <= tolerance:
        return ""
    return (
        f"the initial state breaks joint {worst.joint!r} by {worst.position:.3g} (m, rad) and "
        f"{worst.velocity:.3g} (m/s, rad/s), more than initial_tolerance = {tolerance:g}"
    )


def _point_velocity(scene: Scene, name: str, point: np.ndarray) -> np.ndarray:
    k = scene.body_index(name)
    if k < 0:
        return np.zeros(2)
    body = scene.bodies[k]
    return np.array(body.velocity) + _spin(scene, name) * turned(point - np.array(body.position))


def _spin(scene: Scene, name: str) -> float:
    k = scene.body_index(name)
    body = scene.bodies[k] if k >= 0 else None
    return body.angular_velocity if isinstance(body, PlanarBody) else 0.0


def _gap(scene: Scene, joint: Joint) -> tuple[float, float]:
    if isinstance(joint, Distance):
        return _distance_gap(scene, joint)
    if isinstance(joint, CoordinateDrive | PointDrive):
        return 0.0, abs(_drive_rate(scene, joint) - displacement(joint.motion, joint.level).rate(0.0))
    point = np.array(joint.point)
    slip = _point_velocity(scene, joint.body_b, point) - _point_velocity(scene, joint.body_a, point)
    if isinstance(joint, Prismatic):
        slip = slip - np.array(joint.axis) * (slip @ joint.axis) / np.dot(joint.axis, joint.axis)
    turning = 0.0 if isinstance(joint, Revolute) else _relative_spin(scene, joint.body_a, joint.body_b)
    return 0.0, max(math.hypot(*slip), abs(turning))


def _relative_spin(scene: Scene, a: str, b: str) -> float:
    oriented = [k < 0 or isinstance(scene.bodies[k], PlanarBody) for k in map(scene.body_index, (a, b))]
    return _spin(scene, b) - _spin(scene, a) if all(oriented) else 0.0


def _distance_gap(scene: Scene, joint: Distance) -> tuple[float, float]:
    a, b = np.array(joint.point_a), np.array(joint.point_b)
    actual = math.dist(a, b)
    length = actual if joint.length is None else joint.length
    if actual == 0.0:
        return length, 0.0
    slip = _point_velocity(scene, joint.body_b, b) - _point_velocity(scene, joint.body_a, a)
    return abs(actual - length), abs(slip @ (b - a)) / actual


def _drive_rate(scene: Scene, joint: CoordinateDrive | PointDrive) -> float:
    if isinstance(joint, PointDrive):
        velocity = _point_velocity(scene, joint.body, np.array(joint.point))
        return float(velocity @ joint.direction) / float(np.linalg.norm(joint.direction))
    body = scene.bodies[scene.body_index(joint.body)]
    return {"x": body.velocity[0], "y": body.velocity[1], "angle": _spin(scene, joint.body)}[joint.coordinate]
