"""A planar scene as a MuJoCo model."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from cross_checks.engines.mujoco_.contact import add_contact
from cross_checks.engines.mujoco_.methods import STOCK, pin_options, solref_of
from cross_checks.engines.mujoco_.planar_closures import add_closure
from cross_checks.engines.mujoco_.planar_loads import LOADS
from cross_checks.engines.mujoco_.planar_places import Z, anchor, hinge_name
from cross_checks.engines.mujoco_.shared_forces import takes_shared_forces
from cross_checks.workshop.plan import Plan
from cross_checks.workshop.planar_tree import FIXED, Edge, JointTree, local
from mbs_ref.scene import PlanarBody


def compile_planar(tree: JointTree, plan: Plan) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    pin_options(spec, plan, tree.scene)
    frames = {FIXED: spec.worldbody}

    def place(body: str, point: tuple[float, ...]):
        return frames[tree.scene.body_index(body)], anchor(tree, body, point)

    for edge in tree.edges:
        frames[edge.body] = _add_body(frames[edge.parent], edge, tree)
    for joint in tree.closures:
        add_closure(spec, frames, tree, joint, solref_of(plan))
    if takes_shared_forces(tree.scene):
        spec.option.gravity = (0.0, 0.0, 0.0)  # the weight comes with all other forces
        return spec.compile()
    for load in tree.scene.loads:
        LOADS[type(load)](spec, frames, tree, load)
    for contact in tree.scene.contacts:
        add_contact(spec, place, tree.scene, contact, plan.method.name.endswith(STOCK))
    return spec.compile()


def _add_body(parent: mujoco.MjsBody, edge: Edge, tree: JointTree) -> mujoco.MjsBody:
    """Place the frame at the centre of mass so that zero coordinates are the poses at t = 0."""
    body = tree.scene.bodies[edge.body]
    offset = local(tree, edge.parent, tree.position[edge.body] - tree.position[edge.parent])
    turn = tree.angle[edge.body] - tree.angle[edge.parent]
    frame = parent.add_body(name=body.name, pos=(*offset, 0.0), quat=(np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)))
    # only the z axis turns; equal moments satisfy the triangle inequality MuJoCo checks
    inertia = body.inertia if isinstance(body, PlanarBody) else _particle_inertia(edge)
    frame.explicitinertial = True
    frame.mass, frame.inertia, frame.ipos = body.mass, (inertia,) * 3, (0.0, 0.0, 0.0)
    _add_joints(frame, edge, tree)
    return frame


def _particle_inertia(edge: Edge) -> float:
    """A sliding particle never turns, so any inertia will do; on a rod MuJoCo's floor stands for none."""
    return {"weld": 0.0, "revolute": 2.0 * mujoco.mjMINVAL}.get(edge.kind, 1.0)


def _add_joints(frame: mujoco.MjsBody, edge: Edge, tree: JointTree) -> None:
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    axes = {
        "prismatic": [edge.axis],
        "free": [np.array([1.0, 0.0]), np.array([0.0, 1.0])],
        "free_point": [np.array([1.0, 0.0]), np.array([0.0, 1.0])],
    }.get(edge.kind, [])
    for k, axis in enumerate(axes):
        frame.add_joint(name=f"{frame.name}/slide{k}", type=slide, axis=(*local(tree, edge.body, axis), 0.0))
    if edge.kind in ("revolute", "free"):
        point = local(tree, edge.body, edge.point - tree.position[edge.body])
        frame.add_joint(name=hinge_name(frame.name), type=hinge, axis=Z, pos=(*point, 0.0))
