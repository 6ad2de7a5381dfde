"""A spatial scene as a Pinocchio model: free-flyers and spherical joints carry quaternions.

Every joint's frame stands along the world's axes at t = 0, where all coordinates are neutral.
"""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from cross_checks.workshop.spatial_forces import SpatialApplied
from cross_checks.workshop.spatial_tree import FIXED, SpatialEdge, SpatialTree, depth_first
from mbs_ref.scene import Scene, SpatialBody, symmetric

FREE, BALL = "JointModelFreeFlyer", "JointModelSpherical"


@dataclass
class SpatialMechanism:
    """A Pinocchio model in space and where the scene's bodies are in it."""

    tree: SpatialTree
    model: Any
    data: Any
    applied: SpatialApplied | None  # all loads with gravity; None where gravity is all
    joint: dict[int, int] = field(default_factory=dict)  # body -> the last joint that carries it
    first: dict[int, int] = field(default_factory=dict)  # body -> the first joint between it and its parent
    placement: dict[int, Any] = field(default_factory=dict)  # body -> its centre with its axes, in that joint's frame
    contacts: Any = field(default_factory=lambda: pin.StdVec_RigidConstraintModel())
    closing: list[Any] = field(default_factory=list)  # the scene's joint of each contact
    turns: Any = None  # (k, 4) places of quaternions in q, (k, 3) of their rates in v
    flights: Any = None  # free-flyers: (m, 3) places of positions in q, (m, 3) of velocities in v, (m,) turns
    plain: Any = None  # (p,) places of all other coordinates in q and of their rates in v

    @property
    def n_q(self) -> int:
        return int(self.model.nq)

    def configured(self, q: np.ndarray) -> np.ndarray:
        """Return q with quaternions of norm one, which Pinocchio takes for granted."""
        if not len(self.turns[0]):
            return q
        q = q.copy()
        theta = q[self.turns[0]]
        q[self.turns[0]] = theta / np.linalg.norm(theta, axis=1, keepdims=True)
        return q

    def rate(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return q': quaternions turn with v in the body's axes, and so do free-flyers' velocities."""
        if not len(self.turns[0]):
            return v
        rate = np.zeros(self.n_q)
        rate[self.plain[0]] = v[self.plain[1]]
        theta, omega = q[self.turns[0]], v[self.turns[1]]  # x, y, z, w
        e, w = theta[:, :3], theta[:, 3:]
        rate[self.turns[0][:, :3]] = 0.5 * (w * omega + np.cross(e, omega))
        rate[self.turns[0][:, 3]] = -0.5 * np.sum(e * omega, axis=1)
        places, speeds, which = self.flights
        if len(places):
            speed = v[speeds]
            twice = 2.0 * np.cross(e[which], speed)
            rate[places] = speed + w[which] * twice + np.cross(e[which], twice)
        return rate

    def number_coordinates(self) -> None:
        """Note where quaternions, free-flyers and plain coordinates are."""
        turns, flights, plain = ([], []), ([], [], []), ([], [])
        for joint in list(self.model.joints)[1:]:
            q, v, kind = joint.idx_q, joint.idx_v, joint.shortname()
            if kind == FREE:
                for part, places in zip(flights, (range(q, q + 3), range(v, v + 3), len(turns[0])), strict=True):
                    part.append(places)
                q, v = q + 3, v + 3
            if kind in (FREE, BALL):
                turns[0].append(range(q, q + 4))
                turns[1].append(range(v, v + 3))
            else:
                plain[0].extend(range(q, q + joint.nq))
                plain[1].extend(range(v, v + joint.nv))
        self.turns = tuple(_places(part, k) for part, k in zip(turns, (4, 3), strict=True))
        self.flights = (_places(flights[0], 3), _places(flights[1], 3), np.array(flights[2], dtype=int))
        self.plain = tuple(np.array(part, dtype=int) for part in plain)

    def torques(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return tau: zero, or the scene's loads projected on the joints."""
        if self.applied is None:
            return np.zeros(self.model.nv)
        pin.forwardKinematics(self.model, self.data, q, v)
        outside = self.load_forces(t)
        return -pin.computeStaticTorque(self.model, self.data, q, outside)

    def load_forces(self, t: float) -> Any:
        """Return the loads on every joint in its frame, at the kinematics in `data`."""
        assert self.applied is not None
        outside = [pin.Force.Zero() for _ in range(self.model.njoints)]
        forces = self.applied.on_bodies(t, *self.poses())
        for k, wrench in enumerate(forces):
            joint = self.joint[k]
            at_centre = pin.SE3(np.eye(3), (self.data.oMi[joint] * self.placement[k]).translation)
            outside[joint] += self.data.oMi[joint].actInv(at_centre.act(pin.Force(wrench[:3], wrench[3:])))
        return pin.StdVec_Force(outside)

    def poses(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return places, Euler parameters, velocities and angular velocities at the kinematics in `data`."""
        n = len(self.tree.scene.bodies)
        position, velocity, omega = np.zeros((3, n, 3))
        theta = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
        for k, placement in self.placement.items():
            world = self.data.oMi[self.joint[k]]
            motion = self.data.v[self.joint[k]]
            position[k] = world.act(placement.translation)
            velocity[k] = world.rotation @ (motion.linear + np.cross(motion.angular, placement.translation))
            if isinstance(self.tree.scene.bodies[k], SpatialBody):
                quaternion = pin.Quaternion(world.rotation @ placement.rotation)
                theta[k] = (quaternion.w, quaternion.x, quaternion.y, quaternion.z)
                omega[k] = world.rotation @ motion.angular
        return position, theta, velocity, omega


def _places(ranges: list, width: int) -> np.ndarray:
    return np.array([list(places) for places in ranges], dtype=int).reshape(-1, width)


def mechanism_in_space(tree: SpatialTree, gains: tuple[float, float]) -> SpatialMechanism:
    """Return the scene as a model, with the joints that close loops as contacts of points and frames."""
    scene = tree.scene
    model = pin.Model()
    applied = SpatialApplied(scene) if scene.loads else None
    model.gravity.linear = np.zeros(3) if applied else np.array(scene.gravity)
    mechanism = SpatialMechanism(tree, model, None, applied, joint={FIXED: 0})
    origin = {0: np.zeros(3)}  # of a joint's frame at t = 0
    for edge in depth_first(tree):
        _add_body(mechanism, edge, origin)
    for closure in tree.closures:
        _add_closure(mechanism, closure, origin, gains)
    mechanism.data = model.createData()
    mechanism.number_coordinates()
    return mechanism


def _add_body(mechanism: SpatialMechanism, edge: SpatialEdge, origin: dict[int, np.ndarray]) -> None:
    tree, model = mechanism.tree, mechanism.model
    body = tree.scene.bodies[edge.body]
    point = np.array(edge.joint.point if edge.joint is not None else body.position, dtype=float)
    number = mechanism.joint[edge.parent]
    for k, joint_model in enumerate(_joint_models(edge, body)):
        place = pin.SE3(np.eye(3), point - origin[number])
        number = model.addJoint(number, joint_model, place, f"{body.name}/{k}")
        origin[number] = point
        mechanism.first.setdefault(edge.body, number)
    mechanism.joint[edge.body] = number
    turned = tree.axes(edge.body)
    mechanism.placement[edge.body] = pin.SE3(turned, np.array(body.position) - origin[number])
    inertia = symmetric(body.inertia) if isinstance(body, SpatialBody) else np.zeros((3, 3))
    model.appendBodyToJoint(
        number, pin.Inertia(body.mass, np.zeros(3), inertia), mechanism.placement[edge.body]
    )


def _axis(vector) -> np.ndarray:
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


def _joint_models(edge: SpatialEdge, body) -> list:
    joint = edge.joint
    if not isinstance(body, SpatialBody):  # without orientation: free it slides, on a ball joint it stays
        return [pin.JointModelTranslation()] if joint is None else []
    if joint is None:
        return [pin.JointModelFreeFlyer()]
    if joint.type == "universal":
        axes = (joint.axis_a, joint.axis_b) if body.name == joint.body_b else (joint.axis_b, joint.axis_a)
        return [pin.JointModelRevoluteUnaligned(_axis(axis)) for axis in axes]
    return {
        "spherical": lambda: [pin.JointModelSpherical()],
        "revolute": lambda: [pin.JointModelRevoluteUnaligned(_axis(joint.axis))],
        "prismatic": lambda: [pin.JointModelPrismaticUnaligned(_axis(joint.axis))],
        "cylindrical": lambda: [
            pin.JointModelPrismaticUnaligned(_axis(joint.axis)), pin.JointModelRevoluteUnaligned(_axis(joint.axis))
        ],
        "weld": lambda: [],
    }[joint.type]()  # fmt: skip


def start_rates(mechanism: SpatialMechanism) -> np.ndarray:
    """Return v at t = 0; the frames stand along the world's axes there."""
    tree = mechanism.tree
    rates: list[np.ndarray] = []
    for edge in depth_first(tree):
        body, joint = tree.scene.bodies[edge.body], edge.joint
        point = joint.point if joint is not None else body.position
        sliding = tree.velocity(edge.body, point) - tree.velocity(edge.parent, point)
        turning = tree.relative_spin(edge)
        for model in _joint_models(edge, body):
            kind = model.shortname()
            axis = np.array(getattr(model, "axis", (0.0, 0.0, 0.0)))
            spin = axis @ turning  # the two axes of a universal joint are perpendicular
            rates.append(
                {FREE: np.concatenate((sliding, turning)), BALL: turning, "JointModelTranslation": sliding,
                 "JointModelPrismaticUnaligned": np.array([axis @ sliding])}.get(kind, np.array([spin]))
            )  # fmt: skip
    return np.concatenate(rates) if rates else np.zeros(0)


def _add_closure(mechanism: SpatialMechanism, joint, origin: dict[int, np.ndarray], gains) -> None:
    """A hinge is two shared points on its axis: one row too many, which the proximal solver bears."""
    point = np.array(joint.point, dtype=float)
    weld = joint.type == "weld"
    points = [point] if joint.type != "revolute" else [point - 0.5 * _axis(joint.axis), point + 0.5 * _axis(joint.axis)]
    kind = pin.ContactType.CONTACT_6D if weld else pin.ContactType.CONTACT_3D
    scene: Scene = mechanism.tree.scene
    a, b = (mechanism.joint[scene.body_index(name)] for name in (joint.body_a, joint.body_b))
    for where in points:
        frames = [pin.SE3(np.eye(3), where - origin[number]) for number in (a, b)]
        contact = pin.RigidConstraintModel(
            kind, mechanism.model, a, frames[0], b, frames[1], pin.ReferenceFrame.LOCAL
        )
        contact.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(*gains))
        mechanism.contacts.append(contact)
        mechanism.closing.append(joint)
