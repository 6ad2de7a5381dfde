"""Radau IIA of order 5, the stiff method: implicit, three stages, adaptive or fixed step.

Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
sec. IV.5 and IV.8 (coefficients, simplified Newton with one real and one complex system, error
estimate, Gustafsson's predictive step control).
"""

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop import step as stepping
from mbs_ref.integrators.loop.crossing import NEAR, carried_past
from mbs_ref.integrators.loop.events import EVENT, RETRY, event_tables, give_up
from mbs_ref.integrators.loop.exclusion import step_ends
from mbs_ref.integrators.stages import radau_newton as iteration
from mbs_ref.kernels.border.questions import derivative, regularity
from mbs_ref.kernels.jit import inlined, jit, loop_jit

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 8.0  # of a step
KEEP_LOW, KEEP_HIGH = 1.0, 1.2  # a step this close to the last one keeps its factorization
SAME_STEP = 1e-6  # of a step: what outputs at equal gaps differ by, and less, does not slow the iteration
FEW_ITERATIONS = 2  # of Newton with a Jacobian of the state
ROUNDOFF = 2e-14  # of the state: 100 eps of a position, which a stiff force turns into 100 eps / h of a velocity
MOST_FAILURES = 60  # of Newton in a row, each of which halves the step


class Tolerances(NamedTuple):
    """What errors may be, in the state's units where they are absolute."""

    rtol: float
    atol: np.ndarray  # (n,)
    newton: float  # of a step's tolerance, what the iteration may leave


class Past(NamedTuple):
    """What a step leaves to the next one."""

    values: np.ndarray  # (3,) H_LAST, H_FACTORED, ERROR_LAST
    marks: np.ndarray  # (5,) int: FRESH, STALE, REJECTED, FAILURES, SPENT


H_LAST = 0  # s, step behind the stages that z holds; 0 where there are none to extrapolate
H_FACTORED = 1  # s, step that the factors belong to; 0 for none
ERROR_LAST = 2  # of the last accepted step; 0 for none
FRESH = 0  # 1 where the Jacobian is of this very state
STALE = 1  # 1 where it must be renewed
REJECTED = 2  # 1 after a step whose error was too large
FAILURES = 3  # of Newton in a row
SPENT = 4  # evaluations of the iterations beyond FEW_ITERATIONS since the Jacobian was renewed


@inlined
def _tolerances(options):
    """Return the tolerances; those of a fixed step serve Newton alone."""
    if options.step > 0.0:
        return Tolerances(1e-12, 1e-12 * options.units, 1e-2)
    rtol = options.rtol
    return Tolerances(rtol, options.atol, max(10 * 2.3e-16 / rtol, min(0.03, np.sqrt(rtol))))


@inlined
def _renew_jacobian(model, work, options, run, y, f, scratch, jacobian, past):
    """Make the Jacobian that of the present state; no factors belong to it."""
    iteration.fill_jacobian(model, work, run.t, y, f, options.units, scratch, jacobian)
    run.rhs_calls += y.shape[0]
    past.marks[FRESH], past.marks[STALE], past.marks[SPENT] = 1, 0, 0
    past.values[H_FACTORED] = 0.0


@inlined
def _prepare(model, work, options, run, attempt, y, f, scratch, tolerances, newton, past):
    """Bring Jacobian, factors and the guess of the stages up to this attempt; return whether the factors exist."""
    if attempt.searching:
        past.values[H_LAST] = 0.0
    if past.marks[STALE] == 1:
        _renew_jacobian(model, work, options, run, y, f, scratch, newton.jacobian, past)
    if abs(attempt.h - past.values[H_FACTORED]) > SAME_STEP * attempt.h:
        if not iteration.factor(newton, attempt.h):
            return False
        past.values[H_FACTORED] = attempt.h
    iteration.guess_stages(newton, past.values[H_LAST], attempt.h)
    for k in range(y.shape[0]):
        newton.scale[k] = tolerances.atol[k] + tolerances.rtol * abs(y[k])
    return True


@inlined
def _recover(model, work, options, run, attempt, y, past, search, table):
    """After a failure of Newton renew an old Jacobian, else halve the step; return a status code.

    Near an event where sliding ends, forces turn so fast that no step reaches it but one that begins nearby.
    """
    past.values[H_LAST] = 0.0
    if past.marks[FRESH] == 0:
        past.marks[STALE] = 1
        return leg.RUNNING
    past.marks[FAILURES] += 1
    if options.step > 0.0:
        return leg.NOT_CONVERGED
    if past.marks[FAILURES] > MOST_FAILURES:
        return leg.NON_FINITE
    if attempt.searching:
        give_up(model, work, attempt.t, y, search, table)
    run.h = 0.5 * attempt.h
    run.rejected += 1
    return leg.RUNNING


@jit
def _growth(run, past, h, error, safety):
    """Return the factor of the next step: Gustafsson's prediction, or 1 where that saves a factorization."""
    growth = safety * error**-0.25
    h_last, error_last, rejected = run.h_before, past.values[ERROR_LAST], past.marks[REJECTED] == 1
    if h_last > 0.0 and not rejected and error_last > 0.0:
        growth = min(growth, safety * h / h_last * (error_last / error) ** 0.25 * error**-0.25)
    growth = min(MAX_FACTOR, max(MIN_FACTOR, growth))
    if rejected:
        growth = min(growth, 1.0)
    return 1.0 if KEEP_LOW <= growth <= KEEP_HIGH else growth


@inlined
def _judge(run, attempt, past, error, solved):
    """Return whether the error is borne, and propose the next step: the shorter, the longer Newton took (sec. IV.8)."""
    h = attempt.h
    safety = SAFETY * (2 * iteration.NEWTON_ITERATIONS + 1) / (2 * iteration.NEWTON_ITERATIONS + solved.iterations)
    if not error < 1.0:
        run.rejected += 1
        run.h = h * (MIN_FACTOR if not np.isfinite(error) else max(MIN_FACTOR, safety * error**-0.25))
        past.marks[REJECTED] = 1
        past.values[H_LAST] = 0.0
        return False
    error = max(error, 1e-10)
    growth = _growth(run, past, h, error, safety)
    past.values[ERROR_LAST] = error
    run.h_before = h
    past.marks[REJECTED] = 0
    suggested = h * growth
    run.h = max(suggested, attempt.proposed) if attempt.lands and growth >= 1.0 else suggested
    return True


@inlined
def _is_accurate(model, work, run, attempt, y, f, tolerances, newton, past, solved):
    """Estimate the error and judge it; after a rejection, and in the first step, the estimate is filtered."""
    again = past.marks[REJECTED] == 1 or run.steps == 0
    rtol, atol = tolerances.rtol, tolerances.atol
    error = iteration.error_norm(model, work, attempt.t, attempt.h, y, f, newton, rtol, atol, again)
    return _judge(run, attempt, past, error, solved)


@inlined
def _remember(past, attempt, size, iterations, verdict):
    """Note what an accepted step leaves; nothing is extrapolated across an event.

    The Jacobian is renewed once the iterations that its age costs have taken as many evaluations as a new one takes.
    """
    event = verdict == EVENT
    past.values[H_LAST] = 0.0 if event else attempt.h
    if event:
        past.values[ERROR_LAST] = 0.0
    past.marks[FAILURES] = past.marks[FRESH] = 0
    past.marks[SPENT] += 3 * max(0, iterations - FEW_ITERATIONS)
    past.marks[STALE] = 1 if past.marks[SPENT] > size or event else 0


@loop_jit
def advance_radau(model, work, options, run, y, outputs):
    """Advance y through the output times, in place; return a status code (RUNNING when the chunk is used up)."""
    tolerances, adaptive = _tolerances(options), options.step == 0.0
    span = outputs.times[-1] - outputs.times[0]
    f, trial = np.empty_like(y), np.empty_like(y)
    search, table = event_tables(model)
    ends = step_ends(y, f, trial, np.empty_like(y))
    budget = run.steps + options.chunk
    code = stepping.begin(model, work, options, run, y, f, table)
    if code != leg.RUNNING:
        return code
    if adaptive and run.h == 0.0:
        run.h = stepping.first_step(model, work, run.t, y, f, 3, options, span)
        run.rhs_calls += 1
    jacobian, past = np.empty((y.shape[0], y.shape[0])), Past(np.zeros(3), np.zeros(5, dtype=np.int64))
    _renew_jacobian(model, work, options, run, y, f, trial, jacobian, past)
    newton = iteration.newton_for(jacobian)
    while code == leg.RUNNING and run.steps < budget:
        attempt = stepping.next_attempt(options.step, run, outputs.times[run.next_output], adaptive, search)
        if stepping.stands_still(attempt) or (attempt.h < stepping.SHORTEST * span and not attempt.searching):
            return leg.STEP_TOO_SMALL
        if not _prepare(model, work, options, run, attempt, y, f, trial, tolerances, newton, past):
            return leg.NON_FINITE
        roundoff = ROUNDOFF * (1.0 + options.time / attempt.h) / tolerances.rtol
        solved = iteration.solve_stages(model, work, attempt.t, attempt.h, y, newton, tolerances.newton, roundoff)
        run.rhs_calls += 3 * solved.iterations
        if not solved.converged:
            code = _recover(model, work, options, run, attempt, y, past, search, table)
            continue
        judged = adaptive and not attempt.searching  # a shorter step than an accepted one is borne too
        if judged and not _is_accurate(model, work, run, attempt, y, f, tolerances, newton, past, solved):
            continue
        for k in range(y.shape[0]):
            trial[k] = y[k] + newton.z[2, k]
        ends.known[0], ends.known[1] = 1, 0
        code, verdict = stepping.close_attempt(model, work, options, run, attempt, span, ends, search, table)
        if verdict == stepping.WITHDRAWN:
            past.marks[REJECTED], past.values[H_LAST] = 1, 0.0
            continue
        if verdict == RETRY:
            if adaptive:
                run.h = attempt.proposed
            continue
        if code == leg.RUNNING:
            code = stepping.accept(model, work, options, run, attempt, verdict, y, trial, table, outputs)
        if code == leg.RUNNING:
            _remember(past, attempt, y.shape[0], solved.iterations, verdict)
            if stepping.is_slope_known(ends, verdict):
                f[:] = ends.dy_new
            else:
                derivative(model, work, attempt.t_new, y, f)
                run.rhs_calls += 1
            if adaptive and options.project and regularity(work) < NEAR:
                return leg.NEAR_SINGULAR
    return code


def advance(system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
    """Integrate one leg; DOP853 carries it past singular poses."""
    chunk = partial(advance_radau, system.model, system.work, options, run, y)
    return carried_past(chunk, system, options, run, y, times)


METHOD = leg.Integrator(
    name="radau",
    kind="both",
    order=5,
    embedded=3,
    description="Radau IIA, three stages: the stiff method",
    advance=advance,
    ladder=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
    source="Hairer and Wanner, Solving Ordinary Differential Equations II, sec. IV.8",
    cores=("planar", "spatial"),
)
