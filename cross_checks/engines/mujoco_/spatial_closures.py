"""Spatial joints that close a loop, and springs: soft constraints and tendons."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from cross_checks.engines.mujoco_.planar_loads import linear
from cross_checks.engines.mujoco_.planar_places import world_name
from cross_checks.workshop.spatial_tree import SpatialTree
from mbs_ref.scene import Distance, Revolute, SpringDamper, Weld


def add_closure(spec, frames, tree: SpatialTree, joint, solref: tuple[float, float]) -> None:
    if isinstance(joint, Distance):
        tendon = _spatial_tendon(spec, frames, tree, joint)
        initial = float(np.linalg.norm(np.subtract(joint.point_b, joint.point_a)))
        row = spec.add_equality(name=joint.name, type=mujoco.mjtEq.mjEQ_TENDON, name1=tendon.name)
        row.data[0] = 0.0 if joint.length is None else joint.length - initial
        row.active, row.solref = True, solref
        return
    weld = isinstance(joint, Weld)
    points = [np.array(joint.point, dtype=float)]
    if isinstance(joint, Revolute) and joint.axis is not None:  # a hinge is two shared points on its axis
        axis = np.asarray(joint.axis) / np.linalg.norm(joint.axis)
        points = [points[0] - 0.5 * axis, points[0] + 0.5 * axis]
    first, second = (joint.body_b, joint.body_a) if weld else (joint.body_a, joint.body_b)
    for k, point in enumerate(points):
        kind = mujoco.mjtEq.mjEQ_WELD if weld else mujoco.mjtEq.mjEQ_CONNECT
        row = spec.add_equality(name=f"{joint.name}/{k}", type=kind, objtype=mujoco.mjtObj.mjOBJ_BODY)
        row.name1, row.name2 = world_name(first), world_name(second)
        row.data[0:3] = tree.local(tree.scene.body_index(joint.body_a), point)
        if weld:
            row.data[10] = 1.0  # m/rad, torque scale
        row.active, row.solref = True, solref


def _spatial_tendon(spec, frames, tree: SpatialTree, part):
    tendon = spec.add_tendon(name=part.name)
    for end, (body, point) in enumerate(((part.body_a, part.point_a), (part.body_b, part.point_b))):
        k = tree.scene.body_index(body)
        frames[k].add_site(name=f"{part.name}/{end}", pos=tree.local(k, point))
        tendon.wrap_site(f"{part.name}/{end}")
    return tendon


def add_spring(spec, frames, tree: SpatialTree, load: SpringDamper) -> None:
    tendon = _spatial_tendon(spec, frames, tree, load)
    initial = float(np.linalg.norm(np.subtract(load.point_b, load.point_a)))
    rest = initial if load.rest_length is None else load.rest_length
    tendon.stiffness, tendon.damping = linear(load.stiffness), linear(load.damping)
    tendon.springlength = (0.0 if load.tension_only else rest, rest)
