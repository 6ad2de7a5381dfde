"""A scene as a Pinocchio model; free-flyers and spherical joints carry quaternions.

Every joint's frame stands along the world's axes at t = 0, where all coordinates are neutral.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from cross_checks.linkage.forces import Applied, applied
from cross_checks.linkage.links import FIXED, Closure, Linkage, Z

FREE, BALL = "JointModelFreeFlyer", "JointModelSpherical"


NEXT, AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])  # of each axis


@dataclass
class Mechanism:
    """A Pinocchio model and where the scene's bodies are in it."""

    linkage: Linkage
    model: Any
    data: Any
    applied: Applied | None  # all loads and contacts with gravity; None where gravity is all
    joint: dict[int, int] = field(default_factory=dict)  # body -> the last joint that carries it
    first: dict[int, int] = field(default_factory=dict)  # body -> the first joint between it and its parent
    centre: dict[int, np.ndarray] = field(default_factory=dict)  # body -> (3,) m, its centre of mass in that joint
    contacts: Any = field(default_factory=lambda: pin.StdVec_RigidConstraintModel())
    closing: list[str] = field(default_factory=list)  # the scene's joint of each contact
    turns: Any = None  # (k, 4) places of quaternions in q, (k, 3) of their rates in v
    flights: Any = None  # free-flyers: (m, 3) places of positions in q, (m, 3) of velocities in v, (m,) turns
    plain: Any = None  # (p,) places of all other coordinates in q and of their rates in v

    def configured(self, q: np.ndarray) -> np.ndarray:
        """Return q with quaternions of norm one, which Pinocchio takes for granted."""
        return pin.normalize(self.model, q) if len(self.turns[0]) else q

    def rate(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return q': quaternions turn with v in the body's axes, and so do free-flyers' velocities."""
        if not len(self.turns[0]):
            return v
        rate = np.zeros(self.model.nq)
        rate[self.plain[0]] = v[self.plain[1]]
        theta, omega = q[self.turns[0]], v[self.turns[1]]  # x, y, z, w
        e, w = theta[:, :3], theta[:, 3:]
        rate[self.turns[0][:, :3]] = 0.5 * (w * omega + _cross(e, omega))
        rate[self.turns[0][:, 3]] = -0.5 * np.sum(e * omega, axis=1)
        places, speeds, which = self.flights
        if len(places):
            speed = v[speeds]
            twice = 2.0 * _cross(e[which], speed)
            rate[places] = speed + w[which] * twice + _cross(e[which], twice)
        return rate

    def number_coordinates(self) -> None:
        """Note where quaternions, free-flyers and plain coordinates are."""
        joints = [joint for joint in list(self.model.joints)[1:] if joint.shortname() in (FREE, BALL)]
        flies = np.array([joint.shortname() == FREE for joint in joints], dtype=bool)
        starts = np.array([(joint.idx_q, joint.idx_v) for joint in joints], dtype=int).reshape(-1, 2, 1)
        q, v = np.swapaxes(starts + 3 * flies[:, None, None], 0, 1)  # a free-flyer's quaternion follows its position
        self.turns = q + np.arange(4), v + np.arange(3)
        places, speeds = np.swapaxes(starts[flies] + np.arange(3), 0, 1)
        self.flights = places, speeds, np.flatnonzero(flies)
        sizes = zip((self.model.nq, self.model.nv), self.turns, (places, speeds), strict=True)
        self.plain = tuple(np.setdiff1d(np.arange(size), np.append(turn, place)) for size, turn, place in sizes)

    def torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return tau: zero, or the scene's applied forces projected on the joints."""
        return np.zeros(self.model.nv) if self.applied is None else self.applied.generalized(t, q, v)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the products of rows (n, 3). NumPy's `cross` takes eight times as long for few, at every evaluation."""
    return a.take(NEXT, 1) * b.take(AFTER, 1) - a.take(AFTER, 1) * b.take(NEXT, 1)


def mechanism_of(linkage: Linkage, gains: tuple[float, float]) -> Mechanism:
    """Return the scene as a model, with the joints that close loops as contacts of points and frames."""
    model, loads = pin.Model(), applied(linkage)
    # with loads, gravity comes with them from the one system of applied forces
    model.gravity.linear = linkage.gravity if loads is None else np.zeros(3)
    mechanism = Mechanism(linkage, model, None, loads, joint={FIXED: 0})
    origin = {0: np.zeros(3)}  # of a joint's frame at t = 0
    for link in linkage.links:
        number = mechanism.joint[link.parent]
        for k, (kind, axis) in enumerate(link.freedoms):
            number = model.addJoint(number, JOINTS[kind](axis), _at(link.origin - origin[number]), f"{link.name}/{k}")
            origin[number] = link.origin
            mechanism.first.setdefault(link.body, number)
        mechanism.joint[link.body] = number
        mechanism.centre[link.body] = link.origin + link.centre - origin[number]
        inertia = pin.Inertia(link.mass, np.zeros(3), link.inertia)
        model.appendBodyToJoint(number, inertia, _at(mechanism.centre[link.body]))
    for closure in linkage.closures:
        for contact in _contacts(mechanism, closure, origin, gains):
            mechanism.contacts.append(contact)
            mechanism.closing.append(closure.name)
    mechanism.data = model.createData()
    mechanism.number_coordinates()
    return mechanism


def _at(place: np.ndarray) -> pin.SE3:
    return pin.SE3(np.eye(3), place)


JOINTS: dict[str, Any] = {  # a freedom of a link -> the joint that has it, of its axis
    "free": lambda _: pin.JointModelFreeFlyer(), "ball": lambda _: pin.JointModelSpherical(),
    "slide": pin.JointModelPrismaticUnaligned,
    "turn": lambda axis: pin.JointModelRZ() if np.array_equal(axis, Z) else pin.JointModelRevoluteUnaligned(axis),
}  # fmt: skip


def _contacts(mechanism: Mechanism, closure: Closure, origin: dict[int, np.ndarray], gains) -> Iterable[Any]:
    """Yield the contacts; a hinge is two shared points: one row too many, which the proximal solver tolerates."""
    kind = pin.ContactType.CONTACT_6D if closure.kind == "weld" else pin.ContactType.CONTACT_3D
    a, b = mechanism.joint[closure.a], mechanism.joint[closure.b]
    for point in closure.shared_points:
        at_a, at_b = _at(point - origin[a]), _at(point - origin[b])
        contact = pin.RigidConstraintModel(kind, mechanism.model, a, at_a, b, at_b, pin.ReferenceFrame.LOCAL)
        contact.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(*gains))
        yield contact


def joints_of(model: Any) -> Iterator[tuple]:
    """Yield parent, name, kind, axis, turn and place (m) in the parent, mass, centre and inertia of every joint.

    Joints that turn or slide along no axis of their own have an empty one.
    """
    for i in range(1, model.njoints):
        joint, placement, inertia = model.joints[i].extract(), model.jointPlacements[i], model.inertias[i]
        body = placement.rotation, placement.translation, inertia.mass, inertia.lever, inertia.inertia
        yield (int(model.parents[i]), model.names[i], joint.shortname(), getattr(joint, "axis", np.zeros(0)), *body)
