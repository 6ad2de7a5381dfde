"""A step of the compiled loops, whatever the method: its size, its end, the events in it, and the outputs."""

from typing import NamedTuple

import numpy as np

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop.events import ACTIVE, EVENT, H_NEXT, IDLE, KEEP, has_events, settle_at, watch_at
from mbs_ref.kernels.algebra.dense import all_finite, weighted_norm
from mbs_ref.kernels.border.questions import compliance, derivative, project
from mbs_ref.kernels.jit import inlined, jit

PROJECTION_ITERATIONS = 12
PROJECTION_FAILURE = 1e4  # of the projection tolerance: a larger |C| remaining is a failure
WITHDRAWN = 3  # a verdict beside those of events: the step ended beyond the reach of a loop, and is to be shorter
WITHDRAWAL = 0.2  # step factor after such a step
SHORTEST = 1e-14  # of the leg, a step
SLIVER = 1e-6  # of a step: less is what rounding of the clock leaves over in an output interval of 1e5 steps
TINY = 1e-6  # of the scene's time: a first step where the state tells of none
SAFETY, SHRINK, GROW = 0.9, 0.2, 6.0  # step factors (Hairer, Norsett, Wanner I, sec. II.4)


class Attempt(NamedTuple):
    """One step as it is tried."""

    t: float  # s, where it starts
    t_new: float  # s, where it ends
    h: float  # s
    proposed: float  # s, before it was cut to meet an output or an event
    lands: bool  # ends at an output time
    searching: bool  # for an event, inside a step that was accepted before


@jit
def begin(model, work, options, run, y, dy, table):
    """Settle the modes at the start and evaluate dy/dt there; return a status code."""
    if has_events(table):
        code = settle_at(options.settle, model, work, run.t, y, table, run, options.max_events)
        if code != leg.RUNNING:
            return code
    derivative(model, work, run.t, y, dy)
    run.rhs_calls += 1
    return leg.RUNNING


@jit
def first_step(model, work, t, y, dy, order, options, span):
    """Guess a first step (Hairer, Norsett, Wanner I, sec. II.4, algorithm a-f); costs one evaluation.

    The scene's time stands where the source has a second.
    """
    rtol, atol, unit = options.rtol, options.atol, options.time
    d0 = weighted_norm(y, y, y, rtol, atol)
    d1 = weighted_norm(dy, y, y, rtol, atol) * unit
    h0 = TINY * unit if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1 * unit
    h0 = min(h0, span)
    trial, slope = np.empty_like(y), np.empty_like(y)
    for k in range(y.shape[0]):
        trial[k] = y[k] + h0 * dy[k]
    derivative(model, work, t + h0, trial, slope)
    for k in range(y.shape[0]):
        slope[k] -= dy[k]
    d2 = weighted_norm(slope, y, y, rtol, atol) / h0 * unit * unit
    largest = max(d1, d2)
    h1 = max(TINY * unit, h0 * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** (1.0 / (order + 1)) * unit
    return min(100.0 * h0, min(h1, span))


@jit
def resized(error, error_order, h, proposed, lands, rejected):
    """Return whether a step's error is borne, and the next step (s)."""
    if not error < 1.0:
        factor = SHRINK
        if np.isfinite(error):
            factor = max(SHRINK, SAFETY * error ** (-1.0 / (error_order + 1)))
        return False, h * factor
    growth = GROW
    if error > 0.0:
        growth = min(GROW, max(SHRINK, SAFETY * error ** (-1.0 / (error_order + 1))))
    if rejected:
        growth = min(growth, 1.0)
    suggested = h * growth
    # a step cut short only to land on an output time must not shorten the next one
    return True, max(suggested, proposed) if lands and growth >= 1.0 else suggested


@jit
def choose_step(proposed, reach, evenly, search):
    """Return the step (s), whether it lands on the output `reach` (s) ahead, and whether a search chose it."""
    if search[ACTIVE] != IDLE:
        return search[H_NEXT], search[H_NEXT] >= reach, True
    if proposed >= reach * (1.0 - SLIVER):  # a step of 1e-13 s would divide roundoff by its square
        return reach, True, False
    if evenly and proposed > 0.5 * reach:
        return 0.5 * reach, False, False  # two even steps rather than a whole one and a sliver
    return proposed, False, False


@inlined
def next_attempt(step, run, end, evenly, search):
    """Choose the step: the proposed one, up to the output time `end` (s), or as the search for an event proposes.

    `step` (s) is a fixed one, or 0; a proposed part of it replaces it.
    """
    t, proposed = run.t, run.h if step == 0.0 or 0.0 < run.h < step else step
    h, lands, searching = choose_step(proposed, end - t, evenly, search)
    return Attempt(t, end if lands else t + h, h, proposed, lands, searching)


# Return whether time does not move; a search for an event may propose that.
stands_still = jit(lambda attempt: attempt.t_new == attempt.t and not attempt.searching)


# Return whether dy/dt has been evaluated where the step ends, and nothing has moved the state since.
is_slope_known = jit(lambda ends, verdict: ends.known[1] == 1 and verdict != EVENT)


# Return whether a step that ends at an output would have gone beyond it.
is_cut = jit(lambda proposed, h: proposed * (1.0 - SLIVER) > h)


@jit
def close_step(model, work, t, y, step, restore, tolerance, stop, worst):
    """Check and restore an accepted state; return code and the largest |C| so far."""
    if not all_finite(y):
        return leg.NON_FINITE, worst
    if restore:
        left = project(model, work, t, y, tolerance, PROJECTION_ITERATIONS)
        if not (np.isfinite(left) and all_finite(y)):  # velocities are projected last
            return leg.NON_FINITE, worst
        if left > PROJECTION_FAILURE * tolerance:
            return leg.PROJECTION, worst
    else:
        left, _ = compliance(model, work, t, y)
    worst = max(worst, left)
    if stop and left >= step:
        return leg.COMPLIANCE, worst
    return leg.RUNNING, worst


@jit
def withdraw(run, t, h, span):
    """Shorten a step that ended beyond the reach of a loop; return RUNNING, or PROJECTION where none is shorter.

    What cannot be closed after a step may well be closed after a shorter one: a run ends where its loops do.
    """
    run.rejected += 1
    run.h = WITHDRAWAL * h
    return leg.PROJECTION if t + WITHDRAWAL * h == t or WITHDRAWAL * h < SHORTEST * span else leg.RUNNING


@inlined
def close_attempt(model, work, options, run, attempt, span, ends, search, table):
    """Restore the constraints at the step's end and look for events inside it; return code and verdict.

    An adaptive step that cannot be closed is withdrawn; `span` (s) is that of the leg. The papers' test |C| < h takes
    the method's own step: one cut short to meet an output or an event says nothing of the method, and may be nothing.
    """
    step = max(attempt.h, attempt.proposed)
    code, run.compliance = close_step(
        model, work, attempt.t_new, ends.y_new, step, options.project, options.projection_tolerance,
        options.stop_on_compliance, run.compliance,
    )  # fmt: skip
    if code == leg.PROJECTION and options.step == 0.0 and not attempt.searching:
        return withdraw(run, attempt.t, attempt.h, span), WITHDRAWN
    if code != leg.RUNNING or not has_events(table):
        return code, KEEP
    return code, watch_at(options.watch, model, work, attempt.t, attempt.h, ends, run, search, table)


@jit
def record(run, y, outputs):
    """Store an output state and the largest |C| since the one before."""
    place = run.next_output
    for k in range(y.shape[0]):
        outputs.states[place, k] = y[k]
    outputs.compliance[place] = run.compliance
    run.compliance = 0.0
    run.next_output = place + 1


@inlined
def accept(model, work, options, run, attempt, verdict, y, trial, table, outputs):
    """Move y to the step's end, settle an event there, store an output; return a status code."""
    for k in range(y.shape[0]):
        y[k] = trial[k]
    run.t = attempt.t_new
    run.steps += 1
    if attempt.lands and is_cut(attempt.proposed, attempt.h):
        run.cut += 1
    if verdict == EVENT:
        code = settle_at(options.settle, model, work, attempt.t_new, y, table, run, options.max_events)
        if code != leg.RUNNING:
            return code
    if attempt.lands:
        record(run, y, outputs)
    if run.next_output == outputs.times.shape[0]:
        return leg.DONE
    return leg.TOO_MANY_STEPS if run.steps >= options.max_steps else leg.RUNNING
