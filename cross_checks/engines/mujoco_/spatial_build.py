"""A spatial scene as a MuJoCo model."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from cross_checks.engines.mujoco_.contact import add_contact
from cross_checks.engines.mujoco_.methods import STOCK, pin_options, solref_of
from cross_checks.engines.mujoco_.spatial_closures import add_closure, add_spring
from cross_checks.workshop.plan import Plan
from cross_checks.workshop.planar_tree import FIXED
from cross_checks.workshop.spatial_tree import SpatialEdge, SpatialTree
from mbs_ref.scene import SpatialBody, SpringDamper


def compile_spatial(tree: SpatialTree, plan: Plan) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    pin_options(spec, plan, tree.scene)
    frames = {FIXED: spec.worldbody}

    def place(body: str, point: tuple[float, ...]):
        k = tree.scene.body_index(body)
        return frames[k], tree.local(k, point)

    for edge in tree.edges:
        frames[edge.body] = _add_spatial_body(frames[edge.parent], edge, tree)
    for joint in tree.closures:
        add_closure(spec, frames, tree, joint, solref_of(plan))
    for load in tree.scene.loads:
        assert isinstance(load, SpringDamper)  # every other load is refused before
        add_spring(spec, frames, tree, load)
    for contact in tree.scene.contacts:
        add_contact(spec, place, tree.scene, contact, plan.method.name.endswith(STOCK))
    return spec.compile()


def _add_spatial_body(parent: mujoco.MjsBody, edge: SpatialEdge, tree: SpatialTree) -> mujoco.MjsBody:
    """The frame sits at the centre of mass along the body's axes."""
    body = tree.scene.bodies[edge.body]
    place, theta = tree.seen_from(edge.parent, edge.body)
    frame = parent.add_body(name=body.name, pos=place, quat=theta)
    frame.explicitinertial, frame.mass, frame.ipos = True, body.mass, (0.0, 0.0, 0.0)
    if isinstance(body, SpatialBody):
        frame.fullinertia = body.inertia
    else:
        frame.inertia = (1.0,) * 3  # a particle that only slides never turns
    kinds = mujoco.mjtJoint
    joint = edge.joint
    pos = tree.local(edge.body, joint.point) if joint is not None else np.zeros(3)
    turns = joint is not None and getattr(joint, "axis", None) is not None
    axis = tree.axes(edge.body).T @ joint.axis if turns else np.zeros(3)  # pyright: ignore[reportOptionalMemberAccess]
    for kind in _kinds(edge, body):
        for k, direction in enumerate(np.eye(3) if kind == "slides" else [axis]):
            code = {"slides": kinds.mjJNT_SLIDE, "slide": kinds.mjJNT_SLIDE, "hinge": kinds.mjJNT_HINGE,
                    "ball": kinds.mjJNT_BALL, "free": kinds.mjJNT_FREE}[kind]  # fmt: skip
            options = {} if kind == "free" else {"pos": pos}
            options |= {"axis": direction} if kind in ("slides", "slide", "hinge") else {}
            frame.add_joint(name=f"{body.name}/{kind}{k}", type=code, **options)
    return frame


def _kinds(edge: SpatialEdge, body) -> tuple[str, ...]:
    """Return MuJoCo's joints that an edge is made of."""
    if edge.joint is None:
        return ("free",) if isinstance(body, SpatialBody) else ("slides",)
    by_type = {"spherical": ("ball",), "revolute": ("hinge",), "prismatic": ("slide",), "weld": ()}
    return by_type.get(edge.joint.type, ("slide", "hinge"))


def start_rates(tree: SpatialTree, edge: SpatialEdge) -> np.ndarray:
    body, joint = tree.scene.bodies[edge.body], edge.joint
    to_body = tree.axes(edge.body).T
    point = joint.point if joint is not None else body.position
    sliding = tree.velocity(edge.body, point) - tree.velocity(edge.parent, point)
    turning = tree.relative_spin(edge)
    axis = np.asarray(getattr(joint, "axis", None) or (0.0, 0.0, 0.0))
    axis = axis / (np.linalg.norm(axis) or 1.0)
    rates = {
        "free": np.concatenate((sliding, to_body @ turning)), "slides": sliding, "ball": to_body @ turning,
        "slide": np.array([axis @ sliding]), "hinge": np.array([axis @ turning]),
    }  # fmt: skip
    return np.concatenate([rates[kind] for kind in _kinds(edge, body)] or [np.zeros(0)])
