"""Pinocchio: ABA in trees, proximal constraint dynamics in loops, driven from Python by RK4 or DOP853.

Pinocchio has no integrator. Every right-hand side is one call into C++, every stage a few NumPy
operations, so its times are those of an engine driven from Python.
"""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from time import perf_counter
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin
from scipy.integrate import DOP853

from cross_checks.applied import CLIPPED_CONTACTS, AppliedForces, contact_refusals
from cross_checks.engine import Engine, Method, Refusal
from cross_checks.joint_tree import FIXED, Edge, JointTree, joint_tree, local
from cross_checks.outcome import End, Plan, end_of, plan_run, refuse_spatial, trajectory
from cross_checks.reactions import about, mark, tree_reactions
from mbs_ref.scene import PlanarBody, Revolute, Scene, Weld
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status, Timing, Trajectory

GAINS = (100.0, 20.0)  # 1/s^2, 1/s: Kp and Kd, critically damped at 10 rad/s; Pinocchio's own default is 0, 0
PROXIMAL = {"absolute_accuracy": 1e-14, "mu": 1e-8, "max_iter": 20}  # mu = 0 gives NaN on redundant rows
DATA_BYTES = 32  # times n_v^3: what pinocchio.Data takes for a chain
MOST_BYTES = 1e9
STEPS = (2e-2, 1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4)  # s
RTOLS = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
NO_GAINS = "_no_gains"
SHRINK = "in loops, steps that shrink towards a singular pose end on it, where the proximal solve loses the energy"
DRIFT = "without gains nothing holds the loop once a singular pose has let it slip"
DRIVEN = "driven from Python"

METHODS = (
    Method("dop853", "adaptive", 8, f"SciPy DOP853, {DRIVEN}, Baumgarte gains in loops", RTOLS, wrong_limit=SHRINK),
    Method("rk4", "fixed", 4, f"Runge-Kutta 4, {DRIVEN}, Baumgarte gains in loops", STEPS),
    Method(
        "rk4" + NO_GAINS,
        "fixed",
        4,
        f"Runge-Kutta 4, {DRIVEN}, with Pinocchio's default gains of zero",
        STEPS,
        frozenset({"closed-loop"}),
        wrong_limit=DRIFT,
    ),
)


class Pinocchio(Engine):
    """Pinocchio's forward dynamics under Runge-Kutta methods."""

    name: ClassVar[str] = "pinocchio"
    package: ClassVar[str] = "pinocchio"
    part_types: ClassVar[frozenset[str]] = frozenset(
        {"planar", "point_mass", "revolute", "prismatic", "weld", "distance"}
        | {"force", "torque", "spring_damper", "torsion_spring", "point_bushing", "user_force"}
        | CLIPPED_CONTACTS
    )

    def methods(self) -> tuple[Method, ...]:
        return METHODS

    def version(self) -> str:
        return pin.__version__

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        if scene.dimension != 2:
            return refuse_spatial(self, scene)
        tree = joint_tree(scene)
        size = DATA_BYTES * float(tree.size) ** 3
        reasons = [
            Refusal(f"joint {joint.name!r} closes a loop as {joint.type}; only revolute and weld can", permanent=False)
            for joint in tree.closures
            if not isinstance(joint, Revolute | Weld)
        ]
        if size > MOST_BYTES:
            reasons.append(Refusal(f"pinocchio's data take {size / 1e9:.1f} GB for {tree.size} coordinates", True))
        return reasons + contact_refusals(scene)

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        plan = plan_run(self, scene, settings, times)
        if isinstance(plan, Trajectory):
            return plan
        start = perf_counter()
        tree = joint_tree(scene)
        mechanism = _mechanism(tree, (0.0, 0.0) if plan.method.name.endswith(NO_GAINS) else GAINS)
        contact_data = pin.StdVec_RigidConstraintData()
        rhs = _right_hand_side(mechanism, contact_data)
        initial = np.concatenate((np.zeros(tree.size), tree.rates()))
        built = perf_counter()
        rhs(0.0, initial)
        called = perf_counter()
        advance = _advance_fixed if plan.method.kind == "fixed" else _advance_adaptive
        states, end, steps, calls = advance(rhs, initial, plan, settings.max_steps, scene.breakpoints())
        looped = perf_counter()
        poses = _poses(mechanism, states[: end.samples])
        reached = plan.times[: end.samples]
        states = states[: end.samples]
        return trajectory(
            plan,
            poses,
            end,
            Timing(built - start, called - built, looped - called),
            steps=steps,
            rhs_calls=calls,
            reactions=_reactions(mechanism, rhs, contact_data, reached, states, poses) if settings.reactions else {},
            notes=(DRIVEN,) + (("loads and contacts come from the shared force code",) if mechanism.applied else ()),
        )


ENGINE = Pinocchio


# --- the model -------------------------------------------------------------------------------------


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


def _mechanism(tree: JointTree, gains: tuple[float, float]) -> Mechanism:
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


# --- the right-hand side ---------------------------------------------------------------------------

RightHandSide = Callable[[float, np.ndarray], np.ndarray]


def _right_hand_side(mechanism: Mechanism, contact_data: Any) -> RightHandSide:
    """Return f(t, y) with y = (q, v), one Pinocchio call each."""
    model, data, n = mechanism.model, mechanism.data, mechanism.tree.size
    torques = _torques(mechanism)
    derivative = np.empty(2 * n)
    if not len(mechanism.contacts):

        def tree_rhs(t: float, y: np.ndarray) -> np.ndarray:
            derivative[:n] = y[n:]
            derivative[n:] = pin.aba(model, data, y[:n], y[n:], torques(t, y))
            return derivative

        return tree_rhs
    contacts = mechanism.contacts
    for contact in contacts:
        contact_data.append(contact.createData())
    pin.initConstraintDynamics(model, data, contacts, contact_data)
    proximal = pin.ProximalSettings(PROXIMAL["absolute_accuracy"], PROXIMAL["mu"], PROXIMAL["max_iter"])

    def loop_rhs(t: float, y: np.ndarray) -> np.ndarray:
        q, v = y[:n], y[n:]
        derivative[:n] = v
        derivative[n:] = pin.constraintDynamics(
            model, data, q, v, torques(t, y), contacts, contact_data, proximal
        )
        return derivative

    return loop_rhs


def _torques(mechanism: Mechanism) -> RightHandSide:
    """Return tau(t, y): zero, or the scene's applied forces projected on the joints."""
    n = mechanism.tree.size
    if mechanism.applied is None:
        zero = np.zeros(n)
        return lambda t, y: zero
    applied = mechanism.applied
    return lambda t, y: applied.generalized(t, y[:n], y[n:])


# --- the loop --------------------------------------------------------------------------------------


def _rk4_step(rhs: RightHandSide, t: float, y: np.ndarray, h: float) -> np.ndarray:
    # the right-hand side returns one array, overwritten at each call: each stage is used before the next
    k = rhs(t, y)
    total = y + (h / 6.0) * k
    k = rhs(t + 0.5 * h, y + (0.5 * h) * k)
    total += (h / 3.0) * k
    k = rhs(t + 0.5 * h, y + (0.5 * h) * k)
    total += (h / 3.0) * k
    k = rhs(t + h, y + h * k)
    total += (h / 6.0) * k
    return total


def _advance_fixed(rhs: RightHandSide, y: np.ndarray, plan: Plan, max_steps: int, breakpoints: list[float]):
    states = np.zeros((len(plan.times), len(y)))
    states[0] = y
    n = 0
    for k, count in enumerate(plan.counts, start=1):
        for _ in range(count):
            y = _rk4_step(rhs, n * plan.step, y, plan.step)
            n += 1
        states[k] = y
        if not np.isfinite(y).all():
            break
    end = end_of(states[: k + 1], plan.times, End(k + 1))
    return states, end, n, 4 * n


def _advance_adaptive(rhs: RightHandSide, y: np.ndarray, plan: Plan, max_steps: int, breakpoints: list[float]):
    """Stop the integrator at every output time and breakpoint: nothing is interpolated."""
    states = np.zeros((len(plan.times), len(y)))
    states[0] = y
    steps, calls, h = 0, 0, None
    stops = np.union1d(plan.times, [t for t in breakpoints if 0.0 < t < plan.times[-1]])
    reached = 1
    for begin, stop in pairwise(stops):
        first = None if h is None else min(h, stop - begin)
        solver = DOP853(lambda t, x: rhs(t, x).copy(), begin, y, stop, rtol=plan.rtol, atol=plan.atol, first_step=first)
        while solver.status == "running" and steps < max_steps:
            message = solver.step()
            steps += 1
            # the last step of an interval is cut short; the one before it tells the natural size
            h = max(h or 0.0, solver.step_size or 0.0) if solver.t == stop else solver.step_size
        calls += solver.nfev
        y = solver.y
        if solver.status != "finished":
            return states, _failure(solver, message, reached, max_steps), steps, calls
        if stop == plan.times[reached]:
            states[reached], reached = y, reached + 1
    return states, end_of(states, plan.times, End(len(plan.times))), steps, calls


def _failure(solver: DOP853, message: str | None, reached: int, max_steps: int) -> End:
    if solver.status == "running":
        return End(reached, Status.TOO_MANY_STEPS, f"max_steps = {max_steps} were used up at t = {solver.t:g} s")
    return End(reached, Status.STEP_TOO_SMALL, f"DOP853 stopped at t = {solver.t:g} s: {message}")


def _poses(mechanism: Mechanism, states: np.ndarray):
    """Return Pinocchio's own centres of mass and velocities; angles add up along the tree, beyond one turn."""
    tree, model, data = mechanism.tree, mechanism.model, mechanism.data
    n = len(tree.scene.bodies)
    position, velocity = np.zeros((2, len(states), n, 2))
    for k, y in enumerate(states):
        pin.forwardKinematics(model, data, y[: tree.size], y[tree.size :])
        for body, placement in mechanism.placement.items():
            joint = mechanism.joint[body]
            world = data.oMi[joint]
            centre = placement.translation
            motion = data.v[joint]
            position[k, body] = world.act(centre)[:2]
            velocity[k, body] = (world.rotation @ (motion.linear + np.cross(motion.angular, centre)))[:2]
    _, angle, _, rate = tree.poses(states[:, : tree.size], states[:, tree.size :])
    return position, angle, velocity, rate


def _reactions(mechanism: Mechanism, rhs: RightHandSide, contact_data, times, states: np.ndarray, poses) -> dict:
    """Return reactions by recursive Newton-Euler with loads and loop forces applied from outside."""
    tree, model, data = mechanism.tree, mechanism.model, mechanism.data
    n = tree.size
    wrench = np.zeros((len(states), len(tree.scene.bodies), 3))
    loops = np.zeros((len(tree.closures), len(states), 3))
    for k, (t, y) in enumerate(zip(times, states, strict=True)):
        acceleration = rhs(t, y)[n:].copy()
        pin.forwardKinematics(model, data, y[:n], y[n:])  # neither ABA nor RNEA leaves world placements behind
        outside = [pin.Force.Zero() for _ in range(model.njoints)]
        if mechanism.applied is not None:
            for body, (fx, fy, turn) in enumerate(mechanism.applied.on_bodies(t, y[:n], y[n:])):
                load = pin.Force(np.array([fx, fy, 0.0]), np.array([0.0, 0.0, turn]))
                joint = mechanism.joint[body]
                at_centre = pin.SE3(np.eye(3), data.oMi[joint].act(mechanism.placement[body].translation))
                outside[joint] += data.oMi[joint].actInv(at_centre.act(load))
        for c, (contact, found) in enumerate(zip(mechanism.contacts, contact_data, strict=True)):
            on_first = found.oMc1.act(found.contact_force)
            loops[c, k] = -_planar(on_first)
            outside[contact.joint1_id] += data.oMi[contact.joint1_id].actInv(on_first)
            outside[contact.joint2_id] -= data.oMi[contact.joint2_id].actInv(on_first)
        pin.rnea(model, data, y[:n], y[n:], acceleration, pin.StdVec_Force(outside))
        for body, joint in mechanism.joint.items():
            if body != FIXED:
                wrench[k, body] = _planar(data.oMi[joint].act(data.f[joint]))
    found = tree_reactions(tree, poses, wrench)
    welded = [edge.joint for edge in tree.edges if edge.kind == "weld"]  # one body with its parent to Pinocchio
    found = {name: reaction for name, reaction in found.items() if name not in welded}
    loop = {j.name: about(loops[c], mark(tree, j, poses)) for c, j in enumerate(tree.closures)}
    return found | loop


def _planar(force) -> np.ndarray:
    """Return force and moment of a world wrench in the plane."""
    return np.array([force.linear[0], force.linear[1], force.angular[2]])
