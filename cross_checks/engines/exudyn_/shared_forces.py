"""Loads and contacts that Exudyn lacks, applied by the shared force code."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn.itemInterface as item
import numpy as np

from cross_checks.applied import AppliedForces
from cross_checks.engines.exudyn_.planar_model import Redundant
from cross_checks.joint_tree import joint_tree

SHARED = "loads and contacts come from the shared force code, called through Python"


def add_shared_forces(model: Redundant) -> None:
    """Apply all loads and contacts through one item over all nodes, which calls Python."""
    applied = AppliedForces(joint_tree(model.scene))
    weight = np.outer([body.mass for body in model.scene.bodies], [*model.scene.gravity, 0.0])
    start = np.array([[*body.position, getattr(body, "angle", 0.0)] for body in model.scene.bodies])

    def forces(mbs, t, number, q, v) -> np.ndarray:
        q, v = np.reshape(q, (-1, 3)) + start, np.reshape(v, (-1, 3))
        return (applied.of_poses(t, q, v) - weight).ravel()  # the bodies have their weight already

    size = 3 * len(model.nodes)
    zero = np.zeros((size, size))
    model.mbs.AddObject(
        item.ObjectGenericODE2(
            nodeNumbers=model.nodes, massMatrix=zero, stiffnessMatrix=zero, dampingMatrix=zero,
            forceVector=np.zeros(size), forceUserFunction=forces,
        )
    )  # fmt: skip
    model.notes += (SHARED,)
