"""A scene as a MultibodyPlant, and the reader of its states.

Every body's frame is its joint's, along the world's axes at t = 0.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody import tree as parts
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant

from cross_checks.linkage.links import FIXED, SIX, Closure, Link, Linkage

Shapes = Callable[[MultibodyPlant, dict[int, Any]], None]
JOINTS = {  # Drake's joint of each kind of link
    "revolute": "RevoluteJoint", "prismatic": "PrismaticJoint", "universal": "UniversalJoint", "ball": "BallRpyJoint",
    "planar": "PlanarJoint", "free": "QuaternionFloatingJoint", "weld": "WeldJoint",
}  # fmt: skip
ALONG_AXIS = ("revolute", "prismatic")


def plant_of(
    linkage: Linkage, step: float, gravity: np.ndarray, to_world: bool, add_shapes: Shapes | None = None
) -> MultibodyPlant:
    """Return the plant; `step` (s) is 0 for continuous time, gravity (3,) in m/s^2.

    Constraints `to_world` are tied to Drake's own world body; else to a body that is welded to it. `add_shapes` is
    called with the plant and its bodies by their index in the scene.
    """
    plant = MultibodyPlant(time_step=step)
    if step:
        plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    bodies = {FIXED: plant.world_body()}
    for link in linkage.links:
        bodies[link.body] = body = plant.AddRigidBody(link.name, _inertia(link))
        place = RigidTransform(link.origin - linkage.origin(link.parent))
        plant.AddJoint(_joint(link, bodies[link.parent].body_frame(), place, body.body_frame(), plant))
    if not to_world and tied_to_ground(linkage):
        # a body that stands still; its mass does nothing
        anchor = plant.AddRigidBody("anchor", parts.SpatialInertia.SolidSphereWithMass(1.0, 1.0))
        plant.WeldFrames(plant.world_frame(), anchor.body_frame())
        bodies[FIXED] = anchor
    if add_shapes is not None:
        add_shapes(plant, bodies)
    for closure in linkage.closures:
        for add, a, at_a, b, at_b, *length in constraints_of(linkage, closure):
            place = RigidTransform if closure.kind == "weld" else np.array
            getattr(plant, add)(bodies[a], place(at_a), bodies[b], place(at_b), *length)
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    plant.Finalize()
    return plant


def tied_to_ground(linkage: Linkage) -> bool:
    """Return whether a loop is closed at ground."""
    return any(FIXED in (closure.a, closure.b) for closure in linkage.closures)


def _inertia(link: Link) -> parts.SpatialInertia:
    central = parts.RotationalInertia(*link.inertia[SIX])
    return parts.SpatialInertia.MakeFromCentralInertia(link.mass, link.centre, central)


def _joint(link: Link, parent: Any, place: RigidTransform, child: Any, plant: MultibodyPlant) -> parts.Joint:
    if link.kind == "universal":  # about x of the one frame and y of the other
        axes = RigidTransform(RotationMatrix(np.column_stack((*link.axes, np.cross(*link.axes)))))
        place, child = place @ axes, plant.AddFrame(parts.FixedOffsetFrame(f"{link.name}/axes", child, axes))
    on = plant.AddFrame(parts.FixedOffsetFrame(f"{link.name}/on", parent, place))
    more = [RigidTransform()] if link.kind == "weld" else link.axes if link.kind in ALONG_AXIS else []
    return getattr(parts, JOINTS[link.kind])(f"{link.name}/joint", on, child, *more)


def constraints_of(linkage: Linkage, closure: Closure) -> Iterator[tuple]:
    """Yield the plant's method, body a and the place in it (m), the same of body b, and a rod's length (m).

    A hinge is two shared points on its axis.
    """
    kind = {"rod": "AddDistanceConstraint", "weld": "AddWeldConstraint"}.get(closure.kind, "AddBallConstraint")
    at_a, at_b = closure.point_a - linkage.origin(closure.a), closure.point_b - linkage.origin(closure.b)
    length = (closure.length,) if closure.kind == "rod" else ()
    for along in (-0.5, 0.5) if closure.kind == "hinge" else (0.0,):
        yield (kind, closure.a, at_a + along * closure.axis, closure.b, at_b + along * closure.axis, *length)


class Reader:
    """Reads states in a context of its own."""

    def __init__(self, plant: MultibodyPlant, linkage: Linkage) -> None:
        self.plant, self.context = plant, plant.CreateDefaultContext()
        self.joints = [plant.GetJointByName(f"{link.name}/joint") for link in linkage.links]
        self.bodies = [plant.GetBodyByName(link.name) for link in linkage.of_body]
        self.centres = np.array([link.centre for link in linkage.of_body])
        counted = [(j, k) for j, link in zip(self.joints, linkage.links, strict=True) for k in range(link.size)]
        self.places = [joint.position_start() + k for joint, k in counted]  # a planar joint slides, then turns
        self.speeds = [plant.num_positions() + joint.velocity_start() + k for joint, k in counted]

    def start(self, linkage: Linkage) -> np.ndarray:
        """Return the state at t = 0: a free body's rates are its angular velocity, then its velocity."""
        self.plant.SetDefaultContext(self.context)
        state = self.plant.GetPositionsAndVelocities(self.context).copy()
        for joint, link in zip(self.joints, linkage.links, strict=True):
            first = self.plant.num_positions() + joint.velocity_start()
            state[first : first + len(link.rates)] = link.turning_first
        return state

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return state[self.places], state[self.speeds]

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        self.plant.SetPositionsAndVelocities(self.context, state)
        placed = [self.plant.EvalBodyPoseInWorld(self.context, body) for body in self.bodies]
        moving = [self.plant.EvalBodySpatialVelocityInWorld(self.context, body) for body in self.bodies]
        turn = np.array([pose.rotation().matrix() for pose in placed])
        omega = np.array([velocity.rotational() for velocity in moving])
        arm = np.einsum("nij,nj->ni", turn, self.centres)
        centre = np.array([pose.translation() for pose in placed]) + arm
        speed = np.array([velocity.translational() for velocity in moving]) + np.cross(omega, arm)
        return turn, centre, speed, omega
