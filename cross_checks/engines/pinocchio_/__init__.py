"""Pinocchio: ABA in trees, proximal constraint dynamics in loops, driven from Python by RK4 or DOP853.

Accelerations are Pinocchio's, which has no integrator; Runge-Kutta methods of order 4 and 8 stand around them.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin
from scipy.integrate import DOP853

from cross_checks.engine import LOOPS, End, Loop, Method, Plan, Poses, Refusal, adaptive, exponential, fixed
from cross_checks.engines.pinocchio_.build import Mechanism, mechanism_of
from cross_checks.linkage.forces import Applied, LinkageEngine
from cross_checks.linkage.links import linkage_of
from cross_checks.linkage.motion import Motion, about, poses_of, tree_reactions
from mbs_ref import Scene, Status

GAINS = (100.0, 20.0)  # 1/s^2, 1/s: Kp and Kd, critically damped at 10 rad/s; Pinocchio's own default is 0, 0
NO_GAINS = "_no_gains"
SHRINK = "in loops, steps that shrink towards a singular pose end on it, where the proximal solve loses the energy"
DRIFT = "without gains nothing holds the loop once a singular pose has let it slip"
METHODS = (
    adaptive(
        "dop853", 8, "SciPy DOP853, driven from Python, Baumgarte gains in loops",
        wrong_limit=SHRINK, weak_on=LOOPS, embedded=7, driven_from_python=True,
    ),
    fixed(
        "rk4", 4, "Runge-Kutta 4, driven from Python, Baumgarte gains in loops", stability=exponential(4),
        driven_from_python=True,
    ),
    fixed(
        "rk4" + NO_GAINS, 4, "Runge-Kutta 4, driven from Python, with Pinocchio's default gains of zero",
        requires=LOOPS, stability=exponential(4), wrong_limit=DRIFT, weak_on=LOOPS, driven_from_python=True,
    ),
)  # fmt: skip
PROXIMAL = {"absolute_accuracy": 1e-14, "mu": 1e-8, "max_iter": 20}  # mu = 0 gives NaN on redundant rows
RightHandSide = Callable[[float, np.ndarray], np.ndarray]


def right_hand_side(mechanism: Mechanism, contact_data: Any) -> RightHandSide:
    """Return f(t, y) with y = (q, v), one Pinocchio call each."""
    model, data, n = mechanism.model, mechanism.data, mechanism.model.nq
    derivative = np.empty(n + model.nv)
    if not len(mechanism.contacts):

        def tree_rhs(t: float, y: np.ndarray) -> np.ndarray:
            q, v = mechanism.configured(y[:n]), y[n:]
            derivative[:n] = mechanism.rate(q, v)
            derivative[n:] = pin.aba(model, data, q, v, mechanism.torques(t, q, v))
            return derivative

        return tree_rhs
    contacts = mechanism.contacts
    for contact in contacts:
        contact_data.append(contact.createData())
    pin.initConstraintDynamics(model, data, contacts, contact_data)
    proximal = pin.ProximalSettings(PROXIMAL["absolute_accuracy"], PROXIMAL["mu"], PROXIMAL["max_iter"])

    def loop_rhs(t: float, y: np.ndarray) -> np.ndarray:
        q, v = mechanism.configured(y[:n]), y[n:]
        derivative[:n] = mechanism.rate(q, v)
        torques = mechanism.torques(t, q, v)
        derivative[n:] = pin.constraintDynamics(model, data, q, v, torques, contacts, contact_data, proximal)
        return derivative

    return loop_rhs


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


def advance_fixed(rhs: RightHandSide, y: np.ndarray, plan: Plan) -> Loop:
    states = np.zeros((len(plan.times), len(y)))
    states[0] = y
    n, h = 0, plan.step
    for k, count in enumerate(plan.counts, start=1):
        for _ in range(count):
            y = _rk4_step(rhs, n * h, y, h)
            n += 1
        states[k] = y
        if not isfinite(y[0]):
            return Loop(states, End(k + 1), n, 4 * n)
    return Loop(states, End(len(states)), n, 4 * n)


def advance_adaptive(rhs: RightHandSide, y: np.ndarray, plan: Plan, breakpoints: tuple[float, ...]) -> Loop:
    """Land on every output time and breakpoint: nothing is interpolated. Only breakpoints restart the integrator."""
    states = np.zeros((len(plan.times), len(y)))
    states[0] = y
    steps, calls, reached = 0, 0, 1
    breaks = np.union1d([t for t in breakpoints if 0.0 < t < plan.times[-1]], [0.0, plan.times[-1]])
    for begin, stop in pairwise(breaks.tolist()):
        solver = DOP853(lambda t, x: rhs(t, x).copy(), begin, y, stop, rtol=plan.rtol, atol=plan.atol)
        landings = np.union1d(plan.times[(plan.times > begin) & (plan.times < stop)], [stop]).tolist()
        for landing in landings:
            steps, message = _land(solver, landing, steps, plan.max_steps)
            if solver.status == "failed" or solver.t != landing:
                return Loop(states, _failure(solver, message, reached, plan.max_steps), steps, calls + solver.nfev)
            if landing == plan.times[reached]:
                states[reached], reached = solver.y, reached + 1
        calls, y = calls + solver.nfev, solver.y
    return Loop(states, End(len(plan.times)), steps, calls)


def _land(solver: DOP853, landing: float, steps: int, max_steps: int) -> tuple[int, str | None]:
    """Step to the landing and no further; a step that is cut short there leaves the next one's size as it was."""
    message, bound = None, solver.t_bound
    solver.t_bound = landing
    solver.status = "running"
    while solver.status == "running" and steps < max_steps:
        planned = float(solver.h_abs or 0.0)
        message = solver.step()
        steps += 1
        if solver.status == "finished" and (solver.step_size or 0.0) < planned:
            solver.h_abs = max(planned, solver.h_abs)
    solver.t_bound = bound
    return steps, message


def _failure(solver: DOP853, message: str | None, reached: int, max_steps: int) -> End:
    if solver.status == "running":
        return End(reached, Status.TOO_MANY_STEPS, f"max_steps = {max_steps} were used up at t = {solver.t:g} s")
    return End(reached, Status.STEP_TOO_SMALL, f"DOP853 stopped at t = {solver.t:g} s: {message}")


def motions_of(mechanism: Mechanism, states: np.ndarray) -> Iterator[Motion]:
    """Yield Pinocchio's own motion at each state."""
    linkage, n = mechanism.linkage, mechanism.model.nq
    for y in states:
        q = mechanism.configured(y[:n])
        pin.forwardKinematics(mechanism.model, mechanism.data, q, y[n:])
        bodies = [_of_body(mechanism, k) for k in range(len(linkage.links))]
        position, turn, velocity, omega = map(np.array, zip(*bodies, strict=True))
        yield Motion(position, turn, velocity, omega, linkage.turned(q))


def _of_body(mechanism: Mechanism, k: int) -> tuple:
    """Return position, turn, velocity and angular velocity at the kinematics in `data`."""
    centre = mechanism.centre[k]
    world, moving = mechanism.data.oMi[mechanism.joint[k]], mechanism.data.v[mechanism.joint[k]]
    turn = pin.Quaternion(world.rotation)
    velocity = world.rotation @ (moving.linear + np.cross(moving.angular, centre))
    return world.act(centre), (turn.w, turn.x, turn.y, turn.z), velocity, world.rotation @ moving.angular


def reactions_of(mechanism: Mechanism, rhs: RightHandSide, contact_data, times, states, poses) -> dict:
    """Return reactions by recursive Newton-Euler with loads and loop forces applied from outside."""
    linkage, model, data, n = mechanism.linkage, mechanism.model, mechanism.data, mechanism.model.nq
    wrench = np.zeros((len(states), len(linkage.links), 6))
    loops = {name: np.zeros((len(states), 6)) for name in mechanism.closing}
    for k, (t, y, motion) in enumerate(zip(times, states, motions_of(mechanism, states), strict=True)):
        q, v = mechanism.configured(y[:n]), y[n:]
        acceleration = rhs(t, y)[n:].copy()
        pin.forwardKinematics(model, data, q, v)  # neither ABA nor RNEA leaves world placements behind
        outside = [pin.Force.Zero() for _ in data.oMi]
        if mechanism.applied is not None:
            loads = mechanism.applied.wrenches(t, motion)
            for body, (centre, load) in enumerate(zip(motion.position, loads, strict=True)):
                joint, at_centre = mechanism.joint[body], pin.SE3(np.eye(3), centre)
                outside[joint] += data.oMi[joint].actInv(at_centre.act(pin.Force(load[:3], load[3:])))
        for name, contact, solved in zip(mechanism.closing, mechanism.contacts, contact_data, strict=True):
            on_first = solved.oMc1.act(solved.contact_force)
            loops[name][k] -= on_first.vector
            outside[contact.joint1_id] += data.oMi[contact.joint1_id].actInv(on_first)
            outside[contact.joint2_id] -= data.oMi[contact.joint2_id].actInv(on_first)
        pin.rnea(model, data, q, v, acceleration, pin.StdVec_Force(outside))
        for body, joint in mechanism.first.items():
            wrench[k, body] = data.oMi[joint].act(data.f[joint]).vector
    # a weld, or a particle on a ball joint, is inside one body of pinocchio
    inner = {link.joint for link in linkage.links if not link.freedoms}
    reactions = {name: value for name, value in tree_reactions(linkage, poses, wrench).items() if name not in inner}
    joints = {joint.name: joint for joint in linkage.scene.joints}
    return reactions | {name: about(linkage, poses, joints[name], loop) for name, loop in loops.items()}


DATA_BYTES = 32  # times n_v^3: what pinocchio.Data takes for a chain
MOST_BYTES = 1e9


@dataclass(frozen=True)
class Built:
    """A Pinocchio model with its right-hand side and its state (q, v) at t = 0."""

    mechanism: Mechanism
    contact_data: Any
    rhs: RightHandSide
    start: np.ndarray
    breakpoints: tuple[float, ...]  # s

    @property
    def applied(self) -> Applied | None:
        return self.mechanism.applied


class Pinocchio(LinkageEngine):
    """Pinocchio's forward dynamics under Runge-Kutta methods."""

    name: ClassVar[str] = "pinocchio"
    package: ClassVar[str] = "pinocchio"
    distribution: ClassVar[str] = "pin"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld"})

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = super().topology_refusals(scene)
        size = len(linkage_of(scene).rates)
        if DATA_BYTES * float(size) ** 3 > MOST_BYTES:
            needs = DATA_BYTES * float(size) ** 3 / 1e9
            reasons.append(Refusal(f"pinocchio's data take {needs:.1f} GB for {size} coordinates", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        mechanism = mechanism_of(linkage, (0.0, 0.0) if plan.method.name.endswith(NO_GAINS) else GAINS)
        start = np.concatenate((pin.neutral(mechanism.model), linkage.rates))
        contact_data = pin.StdVec_RigidConstraintData()
        rhs = right_hand_side(mechanism, contact_data)
        return Built(mechanism, contact_data, rhs, start, scene.breakpoints())

    def first_call(self, model: Built, plan: Plan) -> None:
        model.rhs(0.0, model.start)

    def advance(self, model: Built, plan: Plan) -> Loop:
        if plan.method.kind == "fixed":
            return advance_fixed(model.rhs, model.start, plan)
        return advance_adaptive(model.rhs, model.start, plan, model.breakpoints)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        return poses_of(model.mechanism.linkage, motions_of(model.mechanism, states))

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        times = plan.times[: len(states)]
        return reactions_of(model.mechanism, model.rhs, model.contact_data, times, states, poses)


ENGINE = Pinocchio
