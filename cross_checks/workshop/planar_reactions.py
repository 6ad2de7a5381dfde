"""Joint reactions in the trajectory's terms, from the wrenches a tree engine transmits."""

from __future__ import annotations

import numpy as np

from cross_checks.workshop.planar_tree import JointTree, TreeJoint, rotated
from mbs_ref.scene import GROUND, Distance


def tree_reactions(tree: JointTree, poses: tuple[np.ndarray, ...], wrench: np.ndarray) -> dict[str, np.ndarray]:
    """Return the tree joints' force on body b (N, N) and torque (N m) about its mark, each (n_t, 3).

    poses are position, orientation, velocity and angular velocity; wrench (n_t, n, 3) is what a body gets
    from its parent: force (N, N) and moment about the world's origin (N m).
    """
    joints = {joint.name: joint for joint in tree.scene.joints if isinstance(joint, TreeJoint)}
    result = {}
    for edge in tree.edges:
        if edge.joint is None:
            continue
        joint = joints[edge.joint]
        sign = 1.0 if tree.scene.body_names[edge.body] == joint.body_b else -1.0
        result[joint.name] = about(sign * wrench[:, edge.body], mark(tree, joint, poses))
    return result


def about(wrench: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return force and moment about a point (n_t, 2) of a wrench (n_t, 3) about the origin."""
    moment = wrench[:, 2] - (point[:, 0] * wrench[:, 1] - point[:, 1] * wrench[:, 0])
    return np.column_stack((wrench[:, :2], moment))


def mark(tree: JointTree, joint: TreeJoint, poses: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return where the joint's mark on body b is, (n_t, 2) m; on body a where b is ground."""
    name = joint.body_a if joint.body_b == GROUND else joint.body_b
    k = tree.scene.body_index(name)
    ends = (joint.point_a, joint.point_b) if isinstance(joint, Distance) else (joint.point, joint.point)
    world = ends[0] if name == joint.body_a else ends[1]
    turn = (poses[1][:, k] - tree.angle[k]) * tree.turning[k]
    return poses[0][:, k] + rotated(turn, np.array(world) - tree.position[k])
