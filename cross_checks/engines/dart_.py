"""DART, Gazebo's default engine: trees in minimal coordinates under symplectic Euler, loops by its boxed LCP.

The distribution is `dartpy`; the name `dart` belongs to another project.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import dartpy  # an optional extra
import numpy as np

from cross_checks.engine import STEPS, End, Loop, Method, Plan, Refusal
from cross_checks.linkage.forces import Applied, LinkageEngine, applied, read
from cross_checks.linkage.links import FIXED, Closure, Link, Linkage, linkage_of
from mbs_ref import Scene

LOOPS = {"error_reduction": 0.01, "force_mixing": 1e-9, "largest_correction": 10.0}  # DART's defaults, pinned; m/s
EULER, OWN_HINGE = "symplectic_euler", "symplectic_euler_own_hinge"
OPENS = "RevoluteJointConstraint lets loops turn out of their hinges where the axes are not z (seen in 6.20.3)"
METHODS = (
    Method(EULER, "fixed", 1, "DART's only scheme; loops by shared points in its LCP", STEPS),
    Method(OWN_HINGE, "fixed", 1, "the same, hinges that close loops by DART's RevoluteJointConstraint", STEPS,
           requires=frozenset({"spatial", "closed-loop"}), wrong_limit=OPENS, weak_on=frozenset({"closed-loop"})),
)  # fmt: skip


@dataclass(frozen=True)
class Built:
    """A DART world at t = 0, and what reads it."""

    linkage: Linkage
    world: Any
    reader: "Reader"
    applied: Applied | None


class Dart(LinkageEngine):
    """DART's world, stepped from Python: it has no loop of its own."""

    name: ClassVar[str] = "dart"
    package: ClassVar[str] = "dartpy"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    lacks: ClassVar[frozenset[str]] = frozenset({"cylindrical"})
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld"})

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name == OWN_HINGE and not reasons and all(c.kind != "hinge" for c in linkage_of(scene).closures):
            reasons.append(Refusal(f"{method.name} differs only where a hinge closes a loop, and none does", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        loads = applied(linkage)
        world, skeleton = dartpy.simulation.World(), dartpy.dynamics.Skeleton(scene.name)
        nodes: dict[int, Any] = {FIXED: None}
        joints = []
        for link in linkage.links:
            joint, nodes[link.body] = _add_link(skeleton, nodes[link.parent], linkage, link)
            joints.append(joint)
        reader = Reader(linkage, skeleton, nodes, joints)
        world.addSkeleton(skeleton)
        _pin_options(world, plan)
        # with loads, gravity comes with them from the one system of applied forces
        world.setGravity(linkage.gravity if loads is None else np.zeros(3))
        for closure in linkage.closures:
            for constraint in _constraints(nodes, closure, own_hinge=plan.method.name == OWN_HINGE):
                world.getConstraintSolver().addConstraint(constraint)
        skeleton.setVelocities(reader.start_rates())
        return Built(linkage, world, reader, loads)

    def advance(self, model: Built, plan: Plan) -> Loop:
        world, reader = model.world, model.reader
        states = np.empty((len(plan.times), 2 * reader.size))
        states[0] = reader.state()
        steps = 0
        for k, count in enumerate(plan.counts, start=1):
            for _ in range(count):
                if model.applied is not None:
                    motion = read(model.linkage, reader, reader.state())
                    reader.push(model.applied.wrenches(steps * plan.step, motion))
                world.step()
                steps += 1
            states[k] = reader.state()
        return Loop(states, End(len(states)), steps, steps)


ENGINE = Dart


def _pin_options(world: Any, plan: Plan) -> None:
    """Set every option; bodies at rest are deactivated unless that is switched off."""
    world.setTimeStep(plan.step)
    world.setNumSimulationThreads(1)
    sleep = world.getDeactivationOptions()
    sleep.mEnabled = False
    world.setDeactivationOptions(sleep)
    joints = dartpy.constraint.JointConstraint
    joints.setErrorReductionParameter(LOOPS["error_reduction"])
    joints.setConstraintForceMixing(LOOPS["force_mixing"])
    joints.setMaxErrorReductionVelocity(LOOPS["largest_correction"])
    joints.setErrorAllowance(0.0)


def _add_link(skeleton: Any, parent: Any, linkage: Linkage, link: Link) -> tuple[Any, Any]:
    """Add a body whose frame is its joint's, along the world's axes at t = 0."""
    create = getattr(skeleton, f"create{link.kind.capitalize()}JointAndBodyNodePair")
    joint, node = create(*([] if parent is None else [parent]))
    joint.setName(f"{link.name}/joint")
    node.setName(link.name)
    place = dartpy.math.Isometry3()
    place.set_translation(link.origin - linkage.origin(link.parent))
    joint.setTransformFromParentBodyNode(place)
    if link.kind in ("revolute", "prismatic"):
        joint.setAxis(link.axes[0])
    if link.kind == "universal":
        joint.setAxis1(link.axes[0])
        joint.setAxis2(link.axes[1])
    node.setInertia(dartpy.dynamics.Inertia(link.mass, link.centre, link.inertia))
    return joint, node


def _constraints(nodes: dict[int, Any], closure: Closure, own_hinge: bool) -> list[Any]:
    """Return what ties two bodies, or one to the world; a hinge that is not DART's own is two points on its axis."""
    tied = [nodes[body] for body in (closure.b, closure.a) if body != FIXED]
    if closure.kind == "weld":
        return [dartpy.constraint.WeldJointConstraint(*tied)]
    if closure.kind == "hinge" and own_hinge:
        axes = [closure.axis] * len(tied)
        return [dartpy.constraint.RevoluteJointConstraint(*tied, closure.point_a, *axes)]
    return [dartpy.constraint.BallJointConstraint(*tied, point) for point in closure.shared_points]


class Reader:
    """Reads (q, v) of a skeleton from the skeleton itself, and puts it back."""

    def __init__(self, linkage: Linkage, skeleton: Any, nodes: dict[int, Any], joints: list[Any]) -> None:
        self.linkage, self.skeleton, self.joints = linkage, skeleton, joints
        self.nodes = [nodes[link.body] for link in linkage.of_body]
        self.centres = np.array([link.centre for link in linkage.of_body])
        self.size = skeleton.getNumDofs()
        counted = [(joint, k) for joint, link in zip(joints, linkage.links, strict=True) for k in range(link.size)]
        self.places = [joint.getIndexInSkeleton(k) for joint, k in counted]

    def start_rates(self) -> np.ndarray:
        """Return v at t = 0: a free body's is its angular velocity, then its velocity."""
        rates = np.zeros(self.size)
        for joint, link in zip(self.joints, self.linkage.links, strict=True):
            for k, rate in enumerate(link.turning_first):
                rates[joint.getIndexInSkeleton(k)] = rate
        return rates

    def state(self) -> np.ndarray:
        return np.concatenate((self.skeleton.getPositions(), self.skeleton.getVelocities()))

    def push(self, wrenches: np.ndarray) -> None:
        """Apply forces and torques (n_bodies, 6) at the centres of mass for one step."""
        for node, centre, wrench in zip(self.nodes, self.centres, wrenches, strict=True):
            node.setExtForce(wrench[:3], centre, False, True)
            node.addExtTorque(wrench[3:], False)  # setExtTorque would forget the force's moment

    def coordinates(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return state[self.places], state[self.size :][self.places]

    def frames(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        self.skeleton.setPositions(state[: self.size])
        self.skeleton.setVelocities(state[self.size :])
        placed = [node.getWorldTransform() for node in self.nodes]
        turn = np.array([place.rotation() for place in placed])
        omega = np.array([node.getAngularVelocity() for node in self.nodes])
        arm = np.einsum("nij,nj->ni", turn, self.centres)
        centre = np.array([place.translation() for place in placed]) + arm
        speed = np.array([node.getLinearVelocity() for node in self.nodes]) + np.cross(omega, arm)
        return turn, centre, speed, omega
