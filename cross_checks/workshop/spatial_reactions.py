"""Joint reactions in space in the trajectory's terms, from the wrenches a tree engine transmits."""

from __future__ import annotations

from typing import Any

import numpy as np

from cross_checks.workshop.spatial_tree import FIXED, SpatialTree
from mbs_ref.scene import GROUND
from mbs_ref.scene.euler_parameters import rotation_matrices


def spatial_tree_reactions(tree: SpatialTree, poses: tuple[np.ndarray, ...], wrench: np.ndarray) -> dict:
    """Return the tree joints' force on body b (N) and torque about its mark (N m), each (n_t, 6), world axes.

    poses are position, orientation, velocity and angular velocity; wrench (n_t, n, 6) is what a body gets
    from its parent: force (N) and moment about the world's origin (N m).
    """
    result = {}
    for edge in tree.edges:
        if edge.joint is not None:
            sign = 1.0 if tree.scene.body_names[edge.body] == edge.joint.body_b else -1.0
            result[edge.joint.name] = about(sign * wrench[:, edge.body], mark(tree, edge.joint, poses))
    return result


def about(wrench: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return force and moment about a point (n_t, 3) of a wrench (n_t, 6) about the origin."""
    return np.concatenate((wrench[:, :3], wrench[:, 3:] - np.cross(point, wrench[:, :3])), axis=1)


def mark(tree: SpatialTree, joint: Any, poses: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return where the joint's mark on body b is, (n_t, 3) m; on body a where b is ground."""
    k = tree.scene.body_index(joint.body_a if joint.body_b == GROUND else joint.body_b)
    assert k != FIXED
    arm = tree.local(k, joint.point)
    return poses[0][:, k] + rotation_matrices(poses[1][:, k]) @ arm
