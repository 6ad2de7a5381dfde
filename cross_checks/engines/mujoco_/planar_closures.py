"""Planar joints that close a loop: soft constraints."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from cross_checks.engines.mujoco_.planar_places import add_tendon, anchor, world_name
from cross_checks.workshop.planar_tree import JointTree
from mbs_ref.scene import Distance, Revolute, Weld


def add_closure(spec, frames, tree: JointTree, joint, solref: tuple[float, float]) -> None:
    if isinstance(joint, Distance):
        tendon = add_tendon(spec, frames, tree, joint)
        initial = float(np.hypot(*np.subtract(joint.point_b, joint.point_a)))
        row = spec.add_equality(name=joint.name, type=mujoco.mjtEq.mjEQ_TENDON, name1=tendon.name)
        row.data[0] = 0.0 if joint.length is None else joint.length - initial
    else:
        kind = {Revolute: mujoco.mjtEq.mjEQ_CONNECT, Weld: mujoco.mjtEq.mjEQ_WELD}[type(joint)]
        row = spec.add_equality(name=joint.name, type=kind, objtype=mujoco.mjtObj.mjOBJ_BODY)
        # the anchor of a connect is in body 1, of a weld in body 2
        first, second = (joint.body_a, joint.body_b) if isinstance(joint, Revolute) else (joint.body_b, joint.body_a)
        row.name1, row.name2 = world_name(first), world_name(second)
        row.data[0:3] = anchor(tree, joint.body_a, joint.point)
        if isinstance(joint, Weld):
            row.data[10] = 1.0  # m/rad, torque scale
    row.active, row.solref = True, solref
