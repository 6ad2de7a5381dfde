"""The PUMA 560 arm, driven at every joint: inverse dynamics with published torques."""

import numpy as np

from mbs_ref.scene import GROUND, Revolute, RotationDrive, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, dot
from mbs_ref.scene.euler_parameters import from_axis_angle, from_matrix, rotation_matrices
from mbs_ref.scene.signals import Table
from mbs_ref.scenes import read_data

DATA = read_data("puma560")
PATTERN = np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])  # rad/s and rad/s^2: the joints' share of a rate of 1
DURATION = 0.5  # s


def puma560(*, rate: float = 1.0, acceleration: float = 1.0, gravity: NonNegative = 9.81) -> Scene:
    """Move a PUMA 560 from its nominal pose as its six drives say: their torques are the inverse dynamics.

    Joint k turns at rate PATTERN[k] + acceleration PATTERN[k] t (rad/s); gravity (m/s^2). The reactions of the drives
    contain the links, not the rotors and not the friction of its motors.
    """
    pose = np.radians(DATA["nominal_pose_deg"])
    frames = frames_at(pose)
    bodies, joints = [], []
    names = [GROUND, *(f"link{k}" for k in range(1, 7))]
    for k, link in enumerate(DATA["links"]):
        centre = dot(frames[k + 1, :3], (*link["centre"], 1.0))
        axes, origins = frames[: k + 1, :3, 2], frames[: k + 1, :3, 3]
        rates = rate * PATTERN[: k + 1]
        bodies.append(
            SpatialBody(
                name=names[k + 1], mass=link["mass"], inertia=(*link["inertia"], 0.0, 0.0, 0.0), position=tuple(centre),
                orientation=tuple(from_matrix(frames[k + 1, :3, :3])), angular_velocity=tuple(dot(axes.T, rates)),
                velocity=tuple(dot(np.cross(axes, centre - origins).T, rates)),
            )
        )  # fmt: skip
        ends = {"body_a": names[k], "body_b": names[k + 1], "axis": tuple(axes[k])}
        motion = Table(times=(0.0, DURATION), values=(rates[k], rates[k] + acceleration * PATTERN[k] * DURATION))
        joints += [
            Revolute(name=f"joint{k + 1}", point=tuple(origins[k]), **ends),
            RotationDrive(name=f"drive{k + 1}", motion=motion, level="velocity", **ends),
        ]
    return Scene(
        name="puma560", description="Six links on six hinges, all of them driven.", source=DATA["source"],
        duration=DURATION, gravity=(0.0, 0.0, -gravity), bodies=tuple(bodies), joints=tuple(joints),
    )  # fmt: skip


def frames_at(angles: np.ndarray) -> np.ndarray:
    """Return the frames of ground and links (7, 4, 4) at joint angles (6,), rad: z of one is the axis of the next."""
    frames = [np.eye(4)]
    for angle, link in zip(angles, DATA["links"], strict=True):
        step, twist = np.eye(4), from_axis_angle((1.0, 0.0, 0.0), np.radians(link["alpha_deg"]))
        turn = rotation_matrices(from_axis_angle((0.0, 0.0, 1.0), angle))
        step[:3, :3] = np.einsum("ij,jk", turn, rotation_matrices(twist))
        step[:3, 3] = dot(turn, (link["a"], 0.0, link["d"]))
        frames.append(np.einsum("ij,jk", frames[-1], step))
    return np.array(frames)
