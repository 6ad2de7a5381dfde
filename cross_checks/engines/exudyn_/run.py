"""Exudyn's solver, run without surprises."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from math import gcd

import exudyn as exu
import numpy as np
from exudyn.exudynCPP import SolverError

from cross_checks.engines.exudyn_.methods import SOLVERS
from cross_checks.workshop.outcome import End
from cross_checks.workshop.plan import Plan
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import traits
from mbs_ref.trajectory import Status

SPECTRAL_RADIUS = 0.9  # of generalized-alpha at infinite frequency: Exudyn's default, pinned
# tighter, Newton stops at singular poses (generalized-alpha at 1e-10); looser, the order is lost below 1e-8 m
NEWTON = {"relativeTolerance": 1e-9, "absoluteTolerance": 1e-9, "maxIterations": 25}
SMALLEST_STEP = 1e-13  # s, adaptive methods


def options_of(plan: Plan, scene: Scene):
    """Leave nothing to defaults that surprise: halving of the step, modified Newton, output files."""
    options = exu.SimulationSettings()
    options.solution.file.write = False
    options.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    if "closed-loop" in traits(scene):  # sparse elimination fails at once on redundant rows and singular poses
        options.linearSolver.solverType = exu.LinearSolverType.EigenDense
        options.linearSolver.ignoreSingularJacobian = True
    options.parallel.numberOfThreads = 1
    time = options.timeIntegration
    time.verboseMode = 0
    adaptive = plan.method.kind == "adaptive"
    time.adaptiveStep = time.automaticStepSize = adaptive
    time.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    # useIndex2Constraints needs useNewmark, and is then TrapezoidalIndex2 to the last bit
    time.generalizedAlpha.useIndex2Constraints = time.generalizedAlpha.useNewmark = False
    time.newton.useModifiedNewton = False
    for name, value in NEWTON.items():
        setattr(time.newton, name, value)
    if adaptive:
        time.relativeTolerance, time.absoluteTolerance, time.minimumStepSize = plan.rtol, plan.atol, SMALLEST_STEP
    return options


def _solve(model, plan: Plan, options, keep: bool = False) -> str:
    """Run Exudyn's solver and return why it failed, or nothing."""
    try:
        done = model.mbs.SolveDynamic(
            options, solverType=SOLVERS[plan.method.name], updateInitialValues=keep, storeSolver=True
        )
    except SolverError as error:
        return f"exudyn: {error} at t = {model.mbs.systemData.GetTime():g} s"
    return "" if done else f"exudyn's solver returned False at t = {model.mbs.systemData.GetTime():g} s"


def _steps_done(model) -> int:
    """Exudyn's index points to the step to come."""
    return int(model.mbs.sys["dynamicSolver"].it.currentStepIndex) - 1


def first_call(model, plan: Plan, options) -> None:
    """Take one step; the initial values stay as they are."""
    time = options.timeIntegration
    time.startTime, time.numberOfSteps = 0.0, 1
    time.endTime = plan.step or float(plan.times[1])
    options.solution.sensors.writePeriod = time.endTime
    _solve(model, plan, options)


@dataclass(frozen=True)
class Left:
    """What a run of Exudyn's solver left behind, besides what its sensors hold."""

    steps: int
    failure: str = ""  # why the solver stopped
    rows: np.ndarray | None = None  # (n_t, n), adaptive methods: the states read between calls
    samples: int = 0  # of rows


def advance_fixed(model, plan: Plan, options) -> Left:
    """Run the whole interval in one call; sensors record at a common divisor of the output intervals."""
    time = options.timeIntegration
    time.startTime, time.endTime, time.numberOfSteps = 0.0, float(plan.times[-1]), sum(plan.counts)
    options.solution.sensors.writePeriod = reduce(gcd, plan.counts) * plan.step
    failure = _solve(model, plan, options)
    return Left(_steps_done(model), failure)


def sampled_fixed(model, plan: Plan, left: Left) -> tuple[np.ndarray, End]:
    """Return what the sensors recorded at the output times, and how far that goes."""
    at, values = _stored(model)
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


def _stored(model) -> tuple[np.ndarray, np.ndarray]:
    """Return the sensors' times (n,) and values (n, ...)."""
    # all values of one sensor stand together, after its time
    data = [model.mbs.GetSensorStoredData(sensor) for sensor in model.sensors]
    return data[0][:, 0], np.hstack([d[:, 1:] for d in data])


def advance_adaptive(model, plan: Plan, options) -> Left:
    """Call the solver for each output interval: one-step methods restart without loss."""
    system = model.mbs.systemData
    state = exu.ConfigurationType.Initial
    first = np.concatenate((system.GetODE2Coordinates(state), system.GetODE2Coordinates_t(state)))
    rows = np.zeros((len(plan.times), len(first)))
    rows[0] = first
    steps = 0
    time = options.timeIntegration
    for k, (begin, stop) in enumerate(zip(plan.times, plan.times[1:], strict=False), start=1):
        time.startTime, time.endTime, time.numberOfSteps = float(begin), float(stop), 1
        options.solution.sensors.writePeriod = float(stop)
        failure = _solve(model, plan, options, keep=True)
        steps += _steps_done(model)
        rows[k] = np.concatenate((system.GetODE2Coordinates(), system.GetODE2Coordinates_t()))
        if failure or steps > plan.max_steps:
            return Left(steps, failure, rows, k)
    return Left(steps, "", rows, len(rows))


def sampled_adaptive(model, plan: Plan, left: Left) -> tuple[np.ndarray, End]:
    """Return the states read between calls, and how far they go."""
    assert left.rows is not None
    if left.failure:
        return left.rows, End(left.samples, Status.ENGINE_ERROR, left.failure)
    if left.samples < len(plan.times):
        said = f"max_steps = {plan.max_steps} exceeded at t = {plan.times[left.samples]:g} s"
        return left.rows, End(left.samples, Status.TOO_MANY_STEPS, said)
    return left.rows, End(left.samples)
