"""Compiled pieces every in-house loop shares: norms, first step, the close of an accepted step."""

from __future__ import annotations

import numpy as np

from mbs_ref.integrators.loop.events import ACTIVE, H_NEXT, IDLE, settle
from mbs_ref.integrators.loop.leg import (
    COMPLIANCE,
    DONE,
    NON_FINITE,
    PROJECTION,
    RUNNING,
    TOO_MANY_STEPS,
)
from mbs_ref.kernels.border.questions import compliance, derivative, project
from mbs_ref.kernels.jit import inlined, jit

PROJECTION_ITERATIONS = 12
PROJECTION_FAILURE = 1e4  # of the projection tolerance: a larger |C| left is a failure
WITHDRAWAL = 0.2  # step factor after a step that ended where the loops cannot be closed
SHORTEST = 1e-14  # of the leg, a step
SLIVER = 1e-6  # of a step: less is what rounding of the clock leaves over in an output interval of 1e5 steps
TINY = 1e-6  # of the scene's time: a first step where the state tells of none


@jit
def all_finite(y):
    total = 0.0
    for k in range(y.shape[0]):
        total += y[k] * 0.0
    return total == 0.0


@jit
def weighted_norm(x, y0, y1, rtol, atol):
    """Root mean square of x / (atol + rtol max(|y0|, |y1|)) (Hairer, Norsett, Wanner I, eq II.4.11)."""
    total = 0.0
    for k in range(x.shape[0]):
        scaled = x[k] / (atol[k] + rtol * max(abs(y0[k]), abs(y1[k])))
        total += scaled * scaled
    return np.sqrt(total / x.shape[0])


@jit
def begin(model, work, run, y, dy, table, max_events):
    """Settle the modes at the start and evaluate dy/dt there; return a status code."""
    if table.shape[1] > 0:
        code = settle(model, work, run.t, y, table, run, max_events)
        if code != RUNNING:
            return code
    derivative(model, work, run.t, y, dy)
    run.rhs_calls += 1
    return RUNNING


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
    trial = y + h0 * dy
    slope = np.empty_like(y)
    derivative(model, work, t + h0, trial, slope)
    d2 = weighted_norm(slope - dy, y, y, rtol, atol) / h0 * unit * unit
    largest = max(d1, d2)
    h1 = max(TINY * unit, h0 * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** (1.0 / (order + 1)) * unit
    return min(100.0 * h0, min(h1, span))


@inlined
def propose_first(model, work, options, run, y, dy, order, span):
    """Guess the first step of an adaptive run that has none yet."""
    if options.step == 0.0 and run.h == 0.0:
        t = run.t
        run.h = first_step(model, work, t, y, dy, order, options, span)
        run.rhs_calls += 1


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


@jit
def is_cut(proposed, h):
    """Return whether a step that ends at an output would have gone beyond it."""
    return proposed * (1.0 - SLIVER) > h


@jit
def close_step(model, work, t, y, step, restore, tolerance, stop, worst):
    """Check and restore an accepted state; return code and the largest |C| so far."""
    if not all_finite(y):
        return NON_FINITE, worst
    if restore:
        left = project(model, work, t, y, tolerance, PROJECTION_ITERATIONS)
        if not left <= PROJECTION_FAILURE * tolerance:
            return PROJECTION, worst
        if not all_finite(y):  # velocities are projected last
            return NON_FINITE, worst
    else:
        left, _ = compliance(model, work, t, y)
    worst = max(worst, left)
    if stop and left >= step:
        return COMPLIANCE, worst
    return RUNNING, worst


@jit
def withdraw(run, t, h, span):
    """Shorten a step that ended beyond the reach of a loop; return RUNNING, or PROJECTION where none is shorter.

    What cannot be closed after a step may well be closed after a shorter one: a run ends where its loops do.
    """
    run.rejected += 1
    run.h = WITHDRAWAL * h
    return PROJECTION if t + WITHDRAWAL * h == t or WITHDRAWAL * h < SHORTEST * span else RUNNING


@jit
def record(run, y, states, worst_per_time):
    """Keep an output state and the largest |C| since the one before."""
    place = run.next_output
    for k in range(y.shape[0]):
        states[place, k] = y[k]
    worst_per_time[place] = run.compliance
    run.compliance = 0.0
    run.next_output = place + 1


@jit
def end_step(run, lands, y, times, states, worst_per_time, max_steps):
    """Keep the state where the step landed on an output; return RUNNING, DONE or TOO_MANY_STEPS."""
    if lands:
        record(run, y, states, worst_per_time)
    if run.next_output == times.shape[0]:
        return DONE
    return TOO_MANY_STEPS if run.steps >= max_steps else RUNNING
