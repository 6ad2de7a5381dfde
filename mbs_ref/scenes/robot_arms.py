"""Robot arms driven at every joint: inverse dynamics of the PUMA 560 and of the Stanford arm."""

from typing import Any

import numpy as np

from mbs_ref.scene import GROUND, Joint, Prismatic, Revolute, RotationDrive, Scene, SpatialBody, UserConstraint
from mbs_ref.scene.base.part import NonNegative, dot
from mbs_ref.scene.euler_parameters import from_axis_angle, from_matrix, rotation_matrices
from mbs_ref.scene.signals import Table
from mbs_ref.scenes import read_data

ARMS: dict[str, dict[str, Any]] = {name: read_data(name) for name in ("puma560", "stanford_arm")}
DURATION = 0.5  # s


def puma560(*, rate: float = 1.0, acceleration: float = 1.0, gravity: NonNegative = 9.81) -> Scene:
    """Move a PUMA 560 from its nominal pose as its six drives say: their torques are the inverse dynamics.

    Joint k turns at rate p_k + acceleration p_k t (rad/s), p = (1, 2, 3, 1, 2, 3); gravity (m/s^2). The reactions of
    the drives contain the links, not the rotors and not the friction of its motors.
    """
    return _driven("puma560", "Six links on six hinges, all of them driven.", rate, acceleration, gravity)


def stanford_arm(*, rate: float = 1.0, acceleration: float = 1.0, gravity: NonNegative = 9.81) -> Scene:
    """Move the Stanford arm, whose third joint slides, from its nominal pose as its six drives say.

    Joint k moves at rate p_k + acceleration p_k t, p = (1, 2, 0.3, 1, 2, 3) rad/s and m/s; gravity (m/s^2). The
    reactions of the drives are the inverse dynamics of the links, without the motors.
    """
    described = "Six links on five hinges and a slide, all of them driven."
    return _driven("stanford_arm", described, rate, acceleration, gravity)


def _driven(name: str, described: str, rate: float, acceleration: float, gravity: float) -> Scene:
    arm = ARMS[name]
    pattern, slides = np.array(arm["pattern"]), sliding(name)
    pose = pose_at(name, 0.0, rate, acceleration)
    frames = frames_at(name, pose)
    bodies: list[SpatialBody] = []
    joints: list[Joint] = []
    names = [GROUND, *(f"link{k}" for k in range(1, len(pose) + 1))]
    for k, link in enumerate(arm["links"]):
        centre = dot(frames[k + 1, :3], (*link["centre"], 1.0))
        axes, origins = frames[: k + 1, :3, 2], frames[: k + 1, :3, 3]
        rates = rate * pattern[: k + 1]
        turning, sliding_rate = (np.where(slides[: k + 1] == kind, rates, 0.0) for kind in (False, True))
        bodies.append(
            SpatialBody(
                name=names[k + 1], mass=link["mass"], inertia=(*link["inertia"], 0.0, 0.0, 0.0), position=tuple(centre),
                orientation=tuple(from_matrix(frames[k + 1, :3, :3])), angular_velocity=tuple(dot(axes.T, turning)),
                velocity=tuple(dot(np.cross(axes, centre - origins).T, turning) + dot(axes.T, sliding_rate)),
            )
        )  # fmt: skip
        ends: dict[str, Any] = {"body_a": names[k], "body_b": names[k + 1]}
        moved = (float(x) for x in (pose[k], rates[k], acceleration * pattern[k]))
        joints += (_slide if slides[k] else _hinge)(k + 1, ends, origins[k], axes[k], *moved)
    return Scene(
        name=name, description=described, source=arm["source"], duration=DURATION, gravity=(0.0, 0.0, -gravity),
        bodies=tuple(bodies), joints=tuple(joints),
    )  # fmt: skip


def _hinge(k: int, ends: dict[str, Any], point, axis, start: float, rate: float, acceleration: float) -> list[Joint]:
    """Return a hinge and its drive."""
    motion = Table(times=(0.0, DURATION), values=(rate, rate + acceleration * DURATION))
    drive = RotationDrive(name=f"drive{k}", motion=motion, level="velocity", axis=tuple(axis), **ends)
    return [Revolute(name=f"joint{k}", point=tuple(point), axis=tuple(axis), **ends), drive]


def _slide(k: int, ends: dict[str, Any], point, axis, start: float, rate: float, acceleration: float) -> list[Joint]:
    """Return a slide and its drive: how far apart two points of its axis are, `start` (m) at t = 0."""
    reach = "sqrt((b.x - a.x) ** 2 + (b.y - a.y) ** 2 + (b.z - a.z) ** 2)"
    drive = UserConstraint(
        name=f"drive{k}", point_a=tuple(point), point_b=tuple(point + start * axis), **ends,
        expression=f"{reach} - ({start!r} + {rate!r} * t + {0.5 * acceleration!r} * t ** 2)",
    )  # fmt: skip
    return [Prismatic(name=f"joint{k}", point=tuple(point), axis=tuple(axis), **ends), drive]


def sliding(name: str) -> np.ndarray:
    """Return which joints of an arm slide (n,)."""
    return np.array([link.get("slides", False) for link in ARMS[name]["links"]])


def pose_at(name: str, times: Any, rate: float, acceleration: float) -> np.ndarray:
    """Return an arm's joint coordinates (..., n), rad or m, at times (...), s, of its scene."""
    arm, times = ARMS[name], np.asarray(times)[..., None]
    nominal = np.where(sliding(name), arm["nominal_pose"], np.radians(arm["nominal_pose"]))
    return nominal + np.array(arm["pattern"]) * (rate * times + 0.5 * acceleration * times**2)


def frames_at(name: str, pose: np.ndarray) -> np.ndarray:
    """Return the frames of ground and links (n + 1, 4, 4) in a pose (n,): z of one is the axis of the next."""
    frames = [np.eye(4)]
    for coordinate, link in zip(pose, ARMS[name]["links"], strict=True):
        slides = link.get("slides", False)
        angle, offset = (np.radians(link["theta_deg"]), coordinate) if slides else (coordinate, link["d"])
        step, twist = np.eye(4), from_axis_angle((1.0, 0.0, 0.0), np.radians(link["alpha_deg"]))
        turn = rotation_matrices(from_axis_angle((0.0, 0.0, 1.0), angle))
        step[:3, :3] = np.einsum("ij,jk", turn, rotation_matrices(twist))
        step[:3, 3] = dot(turn, (link["a"], 0.0, offset))
        frames.append(np.einsum("ij,jk", frames[-1], step))
    return np.array(frames)
