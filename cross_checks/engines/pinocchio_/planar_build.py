"""A planar scene as a Pinocchio model; coordinates stay in a vector space."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from cross_checks.workshop.planar_forces import AppliedForces
from cross_checks.workshop.planar_tree import FIXED, Edge, JointTree, local
from mbs_ref.scene import PlanarBody, Revolute, Weld


@dataclass(frozen=True)
class Mechanism:
    """A Pinocchio model and where the scene's bodies are in it."""

    tree: JointTree
    model: Any
    data: Any
    joint: dict[int, int]  # body -> joint that carries it
    placement: dict[int, Any]  # body -> its centre of mass, with its axes, in that joint's frame
    applied: AppliedForces | None  # loads, contacts and gravity; None where gravity is all
    contacts: Any = field(default_factory=lambda: pin.StdVec_RigidConstraintModel())

    @property
    def n_q(self) -> int:
        return self.tree.size

    def configured(self, q: np.ndarray) -> np.ndarray:
        """Return q itself: the plane's coordinates are a vector space."""
        return q

    def rate(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return q'."""
        return v

    def torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return tau: zero, or the scene's applied forces projected on the joints."""
        if self.applied is None:
            return np.zeros(self.tree.size)
        return self.applied.generalized(t, q, v)


def _frame(tree: JointTree, body: int, point: np.ndarray) -> pin.SE3:
    """Return a frame at a world point with a body's axes, all at t = 0."""
    angle = tree.angle[body]
    return pin.SE3(pin.utils.rotate("z", angle), np.array([*point, 0.0]))


def _joint_models(edge: Edge, tree: JointTree) -> list:
    """A free body takes two slides and a turn, so that coordinates stay in a vector space."""
    x, y = (np.array([*local(tree, edge.body, np.array(e)), 0.0]) for e in ((1.0, 0.0), (0.0, 1.0)))
    slides = [pin.JointModelPrismaticUnaligned(x), pin.JointModelPrismaticUnaligned(y)]
    axis = np.array([*local(tree, edge.body, edge.axis), 0.0])
    return {
        "revolute": lambda: [pin.JointModelRZ()],
        "prismatic": lambda: [pin.JointModelPrismaticUnaligned(axis)],
        "weld": lambda: [],
        "free_point": lambda: slides,
        "free": lambda: [*slides, pin.JointModelRZ()],
    }[edge.kind]()


def mechanism_of(tree: JointTree, gains: tuple[float, float]) -> Mechanism:
    model = pin.Model()
    applied = AppliedForces(tree) if tree.scene.loads or tree.scene.contacts else None
    # with loads, gravity comes with them from the one system of applied forces
    model.gravity.linear = np.zeros(3) if applied else np.array([*tree.scene.gravity, 0.0])
    joint = {FIXED: 0}
    origin = {0: pin.SE3.Identity()}  # a joint's world frame at t = 0
    placement: dict[int, Any] = {}
    for edge in tree.edges:
        body = tree.scene.bodies[edge.body]
        frame = _frame(tree, edge.body, edge.point)
        number = joint[edge.parent]
        for k, joint_model in enumerate(_joint_models(edge, tree)):
            number = model.addJoint(number, joint_model, origin[number].actInv(frame), f"{body.name}/{k}")
            origin[number] = frame
        joint[edge.body] = number
        placement[edge.body] = origin[number].actInv(_frame(tree, edge.body, tree.position[edge.body]))
        inertia = body.inertia if isinstance(body, PlanarBody) else 0.0
        model.appendBodyToJoint(number, pin.Inertia(body.mass, np.zeros(3), inertia * np.eye(3)), placement[edge.body])
    contacts = pin.StdVec_RigidConstraintModel()
    for closure in tree.closures:
        contacts.append(_contact(tree, model, closure, joint, origin, gains))
    return Mechanism(tree, model, model.createData(), joint, placement, applied, contacts)


def _contact(tree: JointTree, model, closure, joint: dict, origin: dict, gains: tuple[float, float]):
    kind = {Revolute: pin.ContactType.CONTACT_3D, Weld: pin.ContactType.CONTACT_6D}[type(closure)]
    frame = pin.SE3(np.eye(3), np.array([*closure.point, 0.0]))
    numbers = [joint[tree.scene.body_index(name)] for name in (closure.body_a, closure.body_b)]
    a, b = numbers
    contact = pin.RigidConstraintModel(
        kind, model, a, origin[a].actInv(frame), b, origin[b].actInv(frame), pin.ReferenceFrame.LOCAL
    )
    contact.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(*gains))
    return contact
