"""Exudyn's methods, and its solver with every option stated."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial, reduce
from itertools import count
from math import gcd

import exudyn as exu
import numpy as np
from exudyn.exudynCPP import SolverError

from cross_checks.engine import LOOPS, End, Method, Plan, adaptive, exponential, fixed
from mbs_ref import Scene, Status
from mbs_ref.scene.scales import scales_of
from mbs_ref.scene.traits import traits

TREE = "tree_"
CONTACT = "contact_rk44"
PAIR_CONTACT = "pair_contact_rk44"
EXPLICIT_CONTACT = (CONTACT, PAIR_CONTACT)
SINGULAR = "stops at singular poses, or leaves them on another branch and reports success"
HALVED = 100  # times as many steps as a setting has may follow from halving: those that reach the end take up to 31
JUMPS = "at tight tolerances its step control may never come back from the jump of a contact force"
FRICTION = "friction acts on the surface as it was before a body sank in, and gives way to slow slip"
RAMP = "friction grows in proportion to slow slip, up to v_s, not as tanh(v_t / v_s)"
SOLVERS = {
    "generalized_alpha": exu.DynamicSolverType.GeneralizedAlpha,
    "rotation_vector": exu.DynamicSolverType.GeneralizedAlpha,
    "trapezoidal": exu.DynamicSolverType.TrapezoidalIndex2,
    "contact_rk44": exu.DynamicSolverType.RK44,
    "pair_contact_rk44": exu.DynamicSolverType.RK44,
    "tree_dopri5": exu.DynamicSolverType.DOPRI5,
    "tree_rk44": exu.DynamicSolverType.RK44,
    "tree_rk67": exu.DynamicSolverType.RK67,
    "tree_euler": exu.DynamicSolverType.ExplicitEuler,
}
IMPLICIT = {exu.DynamicSolverType.GeneralizedAlpha, exu.DynamicSolverType.TrapezoidalIndex2}
# right-hand sides a step
STAGES = {"contact_rk44": 4, "pair_contact_rk44": 4, "tree_rk44": 4, "tree_rk67": 9, "tree_euler": 1, "tree_dopri5": 7}
SPATIAL, TOUCHING = frozenset({"spatial"}), frozenset({"contact"})


def _in_contact(name: str, text: str, limit: str, also: frozenset[str] = frozenset()) -> Method:
    return fixed(name, None, text, requires=TOUCHING | also, wrong_limit=limit, weak_on=frozenset({"friction"}))


METHODS = (
    fixed("generalized_alpha", 2, "generalized-alpha, index 3, redundant coordinates"),
    fixed("trapezoidal", 2, "trapezoidal rule, index 2, redundant coordinates", wrong_limit=SINGULAR, weak_on=LOOPS),
    fixed("rotation_vector", 2, "generalized-alpha on rotation vectors (Lie group)", requires=SPATIAL),
    _in_contact("contact_rk44", "Runge-Kutta 4 with GeneralContact; bodies without joints", FRICTION),
    _in_contact("pair_contact_rk44", "Runge-Kutta 4 with contact connectors; bodies without joints", RAMP, SPATIAL),
    adaptive("tree_dopri5", 5, "KinematicTree, Dormand-Prince 5", wrong_limit=JUMPS, weak_on=TOUCHING, embedded=4),
    fixed("tree_rk44", 4, "KinematicTree, Runge-Kutta 4", stability=exponential(4)),
    fixed("tree_rk67", 6, "KinematicTree, Runge-Kutta 6 of 7 stages", stability=exponential(6)),
    fixed("tree_euler", 1, "KinematicTree, explicit Euler", stability=exponential(1)),
)


SPECTRAL_RADIUS = 0.9  # of generalized-alpha at infinite frequency: Exudyn's default, pinned
# tighter, Newton stops at singular poses (generalized-alpha at 1e-10); looser, the order is lost below 1e-8 m
NEWTON = {"relativeTolerance": 1e-9, "absoluteTolerance": 1e-9, "maxIterations": 25}
# without joints or contacts: one norm holds all residuals, and at 1e-9 of an orbit's 9 kN no gravity gradient is left
FREE = 1e-12
RESIDUAL = 1e-10  # of the scene's forces, where that is less than Newton's absolute tolerance in N: light bodies
SMALLEST_STEP = 1e-13  # s, adaptive methods
ON_TIME = 1e-9  # of a run: how far before an output time a solver may end
CALLED_FROM = re.compile(r"\s*\[Python file '[^']*', line \d+\]")  # at the end of Exudyn's messages
DENSE = 60  # unknowns up to which dense elimination costs no more than sparse (chains of 10: 50 equal, 110 half more)


def needs_dense(mbs, scene: Scene) -> bool:
    """Return whether to solve with dense elimination, which tolerates dependent constraint rows.

    Trees have no such rows. Loops may: at the start, which Exudyn's own count of freedoms shows, or in a singular
    pose on the way. Sparse elimination stops there. Small systems are solved densely at no cost.
    """
    if "closed-loop" not in traits(scene):
        return False
    return unknowns(mbs) <= DENSE or mbs.ComputeSystemDegreeOfFreedom()["redundantConstraints"] > 0


def unknowns(mbs) -> int:
    """Return the size of the linear system of an implicit step."""
    return len(mbs.systemData.GetODE2Coordinates()) + len(mbs.systemData.GetAECoordinates())


def eliminate(options, *, dense: bool) -> None:
    """Choose the elimination; the dense one leaves out rows that depend on others."""
    kinds = exu.LinearSolverType
    options.linearSolver.solverType = kinds.EigenDense if dense else kinds.EigenSparse
    options.linearSolver.ignoreSingularJacobian = dense


def force_scale(scene: Scene) -> float:
    """Return the force (N) that moves the whole scene by its length within its time."""
    scales = scales_of(scene)
    return sum(body.mass for body in scene.bodies) * scales.speed / scales.time


def spring_rounding(scene: Scene) -> float:
    """Return what rounding leaves of the forces of the stiffest spring (N), below which no residual falls."""
    stiffest = max((float(np.max(getattr(load, "stiffness", 0.0))) for load in scene.loads), default=0.0)
    return 10.0 * float(np.finfo(float).eps) * stiffest * scales_of(scene).length


def options_of(plan: Plan, scene: Scene, *, dense: bool):
    """Return the solver's settings; adaptive halving of the step and output files are off."""
    options = exu.SimulationSettings()
    options.solution.file.write = False
    eliminate(options, dense=dense)
    options.parallel.numberOfThreads = 1
    time = options.timeIntegration
    time.verboseMode = 0
    adaptive = plan.method.kind == "adaptive"
    time.adaptiveStep = time.automaticStepSize = adaptive
    # at its default the solver ends where a contact leaves more than 1 N at a step that it would have shorter
    time.discontinuous.useRecommendedStepSize = adaptive
    time.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    # useIndex2Constraints needs useNewmark, and is then TrapezoidalIndex2 to the last bit
    time.generalizedAlpha.useIndex2Constraints = time.generalizedAlpha.useNewmark = False
    time.newton.useModifiedNewton = True  # the same errors to four figures in half the time, and no pose is lost
    for name, value in NEWTON.items():
        setattr(time.newton, name, value)
    if not scene.joints and "contact" not in traits(scene):
        time.newton.relativeTolerance = FREE
    lowest = min(time.newton.absoluteTolerance, RESIDUAL * force_scale(scene))
    time.newton.absoluteTolerance = max(lowest, spring_rounding(scene))
    if adaptive:
        time.relativeTolerance, time.absoluteTolerance, time.minimumStepSize = plan.rtol, plan.atol, SMALLEST_STEP
    return options


def _solve(model, plan: Plan, options) -> str:
    """Run Exudyn's solver and return why it failed, or nothing."""
    try:
        done = model.mbs.SolveDynamic(options, solverType=SOLVERS[plan.method.name], storeSolver=True)
    except SolverError as error:
        return _why(error, model.mbs)
    return "" if done else f"exudyn's solver returned False at t = {model.mbs.systemData.GetTime():g} s"


def _why(error: Exception, mbs) -> str:
    """Return Exudyn's message without the file and line of this project that called it."""
    said = CALLED_FROM.sub("", str(error)).strip()
    return f"exudyn: {said} at t = {mbs.systemData.GetTime():g} s"


def first_call(model, plan: Plan, options) -> None:
    """Take one step; the initial values stay as they are."""
    time = options.timeIntegration
    time.startTime, time.numberOfSteps = 0.0, 1
    time.endTime = plan.step or float(plan.times[1])
    options.solution.sensors.writePeriod = time.endTime
    _solve(model, plan, options)


@dataclass(frozen=True)
class Left:
    """The result of a run of Exudyn's solver, apart from its sensors' values."""

    steps: int
    failure: str = ""  # why the solver stopped
    rows: np.ndarray | None = None  # (n_t, n), of steps that Exudyn chose: the states read between calls
    samples: int = 0  # of rows
    retried: tuple[str, ...] = ()  # why and how the run was repeated


def advance_fixed(model, plan: Plan, options, *, loops: bool) -> Left:
    """Run the whole interval in one call; sensors record at a common divisor of the output intervals.

    Where an implicit solver stops it starts again with what it offers against that: in a mechanism with loops dense
    elimination, then, as by its default, steps that are halved where Newton's iteration fails, as at a jump of a force.
    """
    time = options.timeIntegration
    time.startTime, time.endTime, time.numberOfSteps = 0.0, float(plan.times[-1]), sum(plan.counts)
    options.solution.sensors.writePeriod = reduce(gcd, plan.counts) * plan.step
    failure, retried = _solve(model, plan, options), []
    if failure and loops and options.linearSolver.solverType == exu.LinearSolverType.EigenSparse:
        retried.append(f"sparse elimination stopped, and dense began anew: {failure}")
        eliminate(options, dense=True)
        failure = _solve(model, plan, options)
    if failure and SOLVERS[plan.method.name] in IMPLICIT:
        retried.append(f"fixed steps stopped, and steps that may be halved began anew: {failure}")
        return replace(_halving(model, plan, options), retried=tuple(retried))
    # Exudyn's index points to the step to come
    return Left(int(model.mbs.sys["dynamicSolver"].it.currentStepIndex) - 1, failure, retried=tuple(retried))


def _halving(model, plan: Plan, options) -> Left:
    """Run an implicit method at steps that are halved where Newton's iteration fails, and grow again."""
    options.timeIntegration.adaptiveStep = True
    most, tried = HALVED * sum(plan.counts), count(1)
    model.mbs.SetPreStepUserFunction(lambda mbs, t: next(tried) <= most)
    alpha = options.timeIntegration.generalizedAlpha
    alpha.useIndex2Constraints = alpha.useNewmark = SOLVERS[plan.method.name] == exu.DynamicSolverType.TrapezoidalIndex2

    def read() -> np.ndarray:
        return np.hstack([model.mbs.GetSensorValues(sensor) for sensor in model.sensors])

    left = _output_by_output(model, plan, options, exu.MainSolverImplicitSecondOrder(), read)
    if left.failure and next(tried) > most:
        return replace(left, failure=f"{left.failure}: halved steps are more than {HALVED} times as many")
    return left


def sampled(model, plan: Plan, left: Left) -> tuple[np.ndarray, End]:
    """Return the states at the output times, and how far they go."""
    return _recorded(model, plan, left) if left.rows is None else _read(plan, left.rows, left)


def _recorded(model, plan: Plan, left: Left) -> tuple[np.ndarray, End]:
    """Return what the sensors recorded."""
    # all values of one sensor stand together, after its time
    data = [model.mbs.GetSensorStoredData(sensor) for sensor in model.sensors]
    at, values = data[0][:, 0], np.hstack([d[:, 1:] for d in data])
    rows = np.zeros((len(plan.times), values.shape[1]))
    wanted = np.concatenate(([0], np.cumsum(plan.counts))) // reduce(gcd, plan.counts)
    # after a failure fewer samples are there, each at its own time
    pairs = zip(wanted, plan.times, strict=True)
    there = np.array([k < len(at) and abs(at[k] - t) < 0.5 * plan.step for k, t in pairs])
    samples = len(there) if there.all() else int(np.argmin(there))
    rows[:samples] = values[wanted[:samples]]
    if left.failure:
        return rows, End(samples, Status.NOT_CONVERGED, left.failure)
    if samples < len(plan.times):
        return rows, End(samples, Status.RESET, f"exudyn left out the output at t = {plan.times[samples]:g} s")
    return rows, End(samples)


def advance_adaptive(model, plan: Plan, options) -> Left:
    """Run an explicit method at steps that Exudyn chooses."""
    time = options.timeIntegration
    time.startTime, time.endTime, time.numberOfSteps = 0.0, float(plan.times[-1]), 1
    time.solverType = SOLVERS[plan.method.name]
    return _output_by_output(model, plan, options, exu.MainSolverExplicit(), partial(_state, model.mbs))


def _output_by_output(model, plan: Plan, options, solver, read: Callable[[], np.ndarray]) -> Left:
    """Run one solver from output to output: it is initialised once, and lands on each, where `read` takes the state."""
    mbs = model.mbs
    options.solution.sensors.active = False
    rows, steps, k = np.zeros((len(plan.times), len(read()))), 0, 0
    try:
        solver.InitializeSolver(mbs, options)
        rows[0] = read()
        for k, stop in enumerate(plan.times[1:].tolist(), start=1):
            solver.it.endTime = stop
            # a solver that a user function stops returns True
            done = solver.SolveSteps(mbs, options) and mbs.systemData.GetTime() > stop - ON_TIME * plan.times[-1]
            steps += solver.it.currentStepIndex - 1  # it points to the step to come, and starts anew in each call
            rows[k] = read()
            if not done or steps > plan.max_steps:
                said = "" if done else f"exudyn's solver stopped at t = {mbs.systemData.GetTime():g} s"
                return Left(steps, said, rows, k)
    except SolverError as error:
        return Left(steps, _why(error, mbs), rows, k)
    return Left(steps, "", rows, len(rows))


def _state(mbs) -> np.ndarray:
    return np.concatenate((mbs.systemData.GetODE2Coordinates(), mbs.systemData.GetODE2Coordinates_t()))


def _read(plan: Plan, rows: np.ndarray, left: Left) -> tuple[np.ndarray, End]:
    """Return what was read between calls."""
    if left.failure:
        status = Status.NOT_CONVERGED if plan.method.kind == "fixed" else Status.ENGINE_ERROR
        return rows, End(left.samples, status, left.failure)
    if left.samples < len(plan.times):
        said = f"max_steps = {plan.max_steps} exceeded at t = {plan.times[left.samples]:g} s"
        return rows, End(left.samples, Status.TOO_MANY_STEPS, said)
    return rows, End(left.samples)
