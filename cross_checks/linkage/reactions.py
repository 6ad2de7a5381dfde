"""Joint reactions in the trajectory's terms, from the wrenches that a tree engine transmits."""

from typing import Any

import numpy as np

from cross_checks.linkage.links import Linkage, Z, lifted
from mbs_ref.scene import GROUND
from mbs_ref.scene.euler_parameters import conjugate, from_axis_angle, product, rotation_matrices

# What a trajectory holds of force and torque in space, by dimension; in the plane force in x and y, torque about z.
COMPONENTS = {2: [0, 1, 5], 3: [0, 1, 2, 3, 4, 5]}


def tree_reactions(linkage: Linkage, poses: tuple[np.ndarray, ...], wrench: np.ndarray) -> dict[str, np.ndarray]:
    """Return the tree joints' force on body b (N) and torque (N m) about its mark: (n_t, 3 or 6), world axes.

    poses are position, orientation, velocity and angular velocity; wrench (n_t, n_bodies, 6) is what a body gets
    from its parent: force (N) and moment about the world's origin (N m).
    """
    joints: dict[str, Any] = {joint.name: joint for joint in linkage.scene.joints}
    held = [(link, joints[link.joint]) for link in linkage.links if link.joint is not None]
    return {
        joint.name: about(linkage, poses, joint, (1.0 if link.name == joint.body_b else -1.0) * wrench[:, link.body])
        for link, joint in held
    }


def about(linkage: Linkage, poses: tuple[np.ndarray, ...], joint, wrench: np.ndarray) -> np.ndarray:
    """Return force and torque about a joint's mark of a wrench (n_t, 6) about the world's origin: (n_t, 3 or 6)."""
    moved = wrench[:, 3:] - np.cross(_mark(linkage, poses, joint), wrench[:, :3])
    return np.concatenate((wrench[:, :3], moved), axis=1)[:, COMPONENTS[linkage.scene.dimension]]


def _mark(linkage: Linkage, poses: tuple[np.ndarray, ...], joint) -> np.ndarray:
    """Return where the joint's mark on body b is, (n_t, 3) m; on body a where b is ground."""
    end = "body_a" if joint.body_b == GROUND else "body_b"
    k = linkage.scene.body_index(getattr(joint, end))
    position, orientation = poses[0][:, k], poses[1][:, k]
    if linkage.scene.dimension == 2:
        turn = from_axis_angle(Z, (orientation - linkage.angle[k]) * linkage.rigid[k])
        position = np.column_stack((position, np.zeros(len(position))))
    else:
        turn = product(orientation, conjugate(linkage.theta[k]))
    return position + rotation_matrices(turn) @ (lifted(joint.mark(end)) - lifted(linkage.scene.bodies[k].position))
