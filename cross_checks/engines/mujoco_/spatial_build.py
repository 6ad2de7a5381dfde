"""A spatial scene as a MuJoCo model."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from cross_checks.engines.mujoco_.contact import add_contact
from cross_checks.engines.mujoco_.methods import STOCK, pin_options, solref_of
from cross_checks.engines.mujoco_.planar_loads import linear
from cross_checks.engines.mujoco_.spatial_closures import add_closure, add_spring
from cross_checks.workshop.plan import Plan
from cross_checks.workshop.planar_tree import FIXED
from cross_checks.workshop.spatial_tree import SpatialEdge, SpatialTree
from mbs_ref.scene import Revolute, SpatialBody, SpringDamper, TorsionSpring, Universal

FREE, BALL, SLIDE, HINGE = (
    mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE,
)  # fmt: skip
SAME_AXIS = 1e-9  # of directions of length 1


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
        if isinstance(load, TorsionSpring):
            _add_to_hinge(spec, tree, load)
        else:
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
    pos = tree.local(edge.body, edge.joint.point) if edge.joint is not None else np.zeros(3)
    for k, (kind, axis) in enumerate(_freedoms(edge, tree)):
        options = {} if kind is FREE else {"pos": pos}
        options |= {} if axis is None else {"axis": tree.axes(edge.body).T @ axis}
        frame.add_joint(name=f"{body.name}/{k}", type=kind, **options)
    return frame


def _freedoms(edge: SpatialEdge, tree: SpatialTree) -> list[tuple[mujoco.mjtJoint, np.ndarray | None]]:
    """Return MuJoCo's joints that an edge is made of, each with its axis (world, t = 0)."""
    axes = axes_of(edge, tree)
    if edge.joint is None:
        free = isinstance(tree.scene.bodies[edge.body], SpatialBody)
        return [(FREE, None)] if free else [(SLIDE, axis) for axis in tree.axes(edge.body).T]
    kinds = {"spherical": (BALL,), "weld": (), "prismatic": (SLIDE,), "cylindrical": (SLIDE, HINGE)}
    listed = kinds.get(edge.joint.type, (HINGE,) * len(axes))
    return [(kind, None if kind is BALL else axes[min(k, len(axes) - 1)]) for k, kind in enumerate(listed)]


def axes_of(edge: SpatialEdge, tree: SpatialTree) -> list[np.ndarray]:
    """Return the unit axes (world, t = 0) that a joint turns about or slides along, that of the parent first."""
    joint = edge.joint
    if isinstance(joint, Universal):
        on_parent = tree.scene.body_index(joint.body_a) == edge.parent
        asked = (joint.axis_a, joint.axis_b) if on_parent else (joint.axis_b, joint.axis_a)
    else:
        asked = () if joint is None or getattr(joint, "axis", None) is None else (joint.axis,)
    return [np.asarray(axis) / np.linalg.norm(axis) for axis in asked]


def _add_to_hinge(spec, tree: SpatialTree, load: TorsionSpring) -> None:
    """Give a hinge the spring and damper that act about it."""
    edge = hinge_of(tree, load)
    assert edge is not None  # every other torsion spring is refused before
    hinge = spec.joint(f"{tree.scene.bodies[edge.body].name}/0")
    with_b = tree.scene.body_index(load.body_b) == edge.body
    along = float(np.sign(axes_of(edge, tree)[0] @ np.asarray(load.axis))) * (1.0 if with_b else -1.0)
    hinge.stiffness, hinge.damping = linear(load.stiffness), linear(load.damping)
    hinge.springref = along * (load.rest_angle or 0.0)


def hinge_of(tree: SpatialTree, load: TorsionSpring) -> SpatialEdge | None:
    """Return the hinge of the tree between the two bodies of a torsion spring, about its axis; None where none is."""
    ends = {tree.scene.body_index(load.body_a), tree.scene.body_index(load.body_b)}
    for edge in tree.edges:
        if {edge.parent, edge.body} == ends and isinstance(edge.joint, Revolute):
            across = np.cross(axes_of(edge, tree)[0], np.asarray(load.axis) / np.linalg.norm(np.asarray(load.axis)))
            return edge if np.abs(across).max() < SAME_AXIS else None
    return None


def start_rates(tree: SpatialTree, edge: SpatialEdge) -> np.ndarray:
    body, joint = tree.scene.bodies[edge.body], edge.joint
    to_body = tree.axes(edge.body).T
    point = joint.point if joint is not None else body.position
    sliding = tree.velocity(edge.body, point) - tree.velocity(edge.parent, point)
    turning = tree.relative_spin(edge)
    rates = {FREE: np.concatenate((sliding, to_body @ turning)), BALL: to_body @ turning}
    along = {SLIDE: sliding, HINGE: turning}  # a universal joint's axes are square to each other
    found = [rates[kind] if axis is None else np.array([axis @ along[kind]]) for kind, axis in _freedoms(edge, tree)]
    return np.concatenate(found or [np.zeros(0)])
