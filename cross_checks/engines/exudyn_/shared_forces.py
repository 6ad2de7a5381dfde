"""Loads and contacts that Exudyn lacks, applied by the shared force code."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

import exudyn.itemInterface as item
import numpy as np

from cross_checks.engines.exudyn_.planar_model import Redundant
from cross_checks.linkage.forces import SHARED, Applied
from cross_checks.linkage.links import linkage_of
from mbs_ref.scene import PlanarBody


def add_shared_forces(model: Redundant) -> None:
    """Apply all loads and contacts through one item over all nodes, which calls Python."""
    applied = Applied(linkage_of(model.scene))
    weight = np.outer([body.mass for body in model.scene.bodies], [*model.scene.gravity, 0.0])
    start = np.array([[*body.position, getattr(body, "angle", 0.0)] for body in model.scene.bodies])

    used = np.array([[True, True, isinstance(body, PlanarBody)] for body in model.scene.bodies])

    def forces(mbs, t, number, q, v) -> np.ndarray:
        pose, rate = start.copy(), np.zeros_like(start)
        pose[used] += q
        rate[used] = v
        return (applied.in_plane(t, pose, rate) - weight)[used]  # the bodies have their weight already

    size = int(used.sum())  # a point mass has a node of two coordinates
    zero = np.zeros((size, size))
    model.mbs.AddObject(
        item.ObjectGenericODE2(
            nodeNumbers=model.nodes, massMatrix=zero, stiffnessMatrix=zero, dampingMatrix=zero,
            forceVector=np.zeros(size), forceUserFunction=forces,
        )
    )  # fmt: skip
    model.notes += (SHARED,)
