"""Explicit Runge-Kutta methods, fixed-step or adaptive; a tableau is data."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.integrators.events import EVENT, RETRY, event_tables, settle, watch
from mbs_ref.integrators.leg import (
    CLOCK_COMPLIANCE,
    CLOCK_H,
    CLOCK_T,
    COUNT_OUTPUT,
    COUNT_REJECTED,
    COUNT_RHS,
    COUNT_STEPS,
    DONE,
    NON_FINITE,
    PROJECTION,
    RUNNING,
    SINGULAR,
    STEP_TOO_SMALL,
    Advance,
    Leg,
    Options,
    Progress,
    run_chunks,
)
from mbs_ref.integrators.step_control import (
    begin,
    choose_step,
    close_step,
    end_step,
    first_step,
    record,
    weighted_norm,
    withdraw,
)
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.questions import derivative, project, regularity, tangent
from mbs_ref.system import System

# Roundoff in an acceleration grows as eps / sigma^3 near a singular pose, with the relative closure pivot
# sigma^2. A step that ends where this harms the asked accuracy is shortened once, so that the next one
# passes over the pose; where that does not help it may end there, unless even positions would suffer.
NOISY_PIVOT = 2e-17  # over rtol, to the power 2/3
NOISY_STAGE = 1e-19  # likewise for a stage inside a step, whose weight is smaller
SINGULAR_PIVOT = 1e-17  # over rtol
PATIENT_AVOIDED, MOST_AVOIDED = 6, 60  # attempts in a row to end a step away from a singular pose
NEAR_SINGULAR = 0.1  # relative closure pivot below which stages are projected
STAGE_ITERATIONS = 6
AVOID_STAGE = 0.93  # step factor after a stage came too close to one
AVOID = 0.77  # step factor after ending too close to a singular pose
SAFETY, SHRINK, GROW = 0.9, 0.2, 6.0  # step factors (Hairer, Norsett, Wanner I, sec. II.4)


class Tableau(NamedTuple):
    """Butcher coefficients; error rows weigh the stages and, last, the slope at the new point."""

    a: np.ndarray  # (s, s)
    b: np.ndarray  # (s,)
    c: np.ndarray  # (s,)
    error: np.ndarray  # (s + 1,) main error weights; empty for fixed-step methods
    error_low: np.ndarray  # (s + 1,) second estimate (DOP853), or empty
    order: int
    error_order: int


@jit
def _stages(model, work, tableau, t, h, y, slopes, trial, restore, tolerance):
    """Fill slopes[1:s]; slopes[0] is given. Leave the new state in `trial`; return the worst stage's pivot.

    With `restore` every stage is first projected onto the constraints. Near a singular pose the
    accelerations off the manifold grow without bound while those on it stay smooth.
    """
    stages = tableau.b.shape[0]
    n = y.shape[0]
    pivot = 1.0
    for i in range(1, stages):
        for k in range(n):
            trial[k] = y[k]
        for j in range(i):
            weight = h * tableau.a[i, j]
            if weight != 0.0:
                for k in range(n):
                    trial[k] += weight * slopes[j, k]
        t_stage = t + tableau.c[i] * h
        if restore:
            project(model, work, t_stage, trial, tolerance, STAGE_ITERATIONS)
        derivative(model, work, t_stage, trial, slopes[i])
        if restore:
            pivot = min(pivot, regularity(work))
    for k in range(n):
        trial[k] = y[k]
    for j in range(stages):
        weight = h * tableau.b[j]
        if weight != 0.0:
            for k in range(n):
                trial[k] += weight * slopes[j, k]
    return pivot


@jit
def _combine(weights, slopes, h, out):
    for k in range(out.shape[0]):
        out[k] = 0.0
    for j in range(weights.shape[0]):
        if weights[j] != 0.0:
            for k in range(out.shape[0]):
                out[k] += h * weights[j] * slopes[j, k]


@jit
def _error_norm(model, work, tableau, slopes, h, y, trial, scratch, rtol, atol, restore):
    """Return the scaled error; with a second estimate as in DOP853 (Hairer, Norsett, Wanner I, sec. II.10).

    With `restore` only the error along the constraints counts: projection removes the rest, which near a
    singular pose is roundoff magnified by eps / sigma^3.
    """
    _combine(tableau.error, slopes, h, scratch)
    if restore:
        tangent(model, work, scratch)
    main = weighted_norm(scratch, y, trial, rtol, atol)
    if tableau.error_low.shape[0] == 0:
        return main
    _combine(tableau.error_low, slopes, h, scratch)
    if restore:
        tangent(model, work, scratch)
    low = weighted_norm(scratch, y, trial, rtol, atol)
    scale = main * main + 0.01 * low * low
    return 0.0 if scale == 0.0 else main * main / np.sqrt(scale)  # NaN must stay NaN, and be rejected


@jit
def _resize(error, error_order, h, proposed, lands, rejected):
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
def advance_explicit(model, work, tableau, options, run, y, times, states, worst_per_time):
    """Advance y through times[1:], in place; return a status code (RUNNING when the chunk is used up)."""
    clock, counts = run.clock, run.counts
    stages = tableau.b.shape[0]
    n = y.shape[0]
    adaptive = options.step == 0.0
    slopes = np.zeros((stages + 1, n))
    trial = np.empty(n)
    scratch = np.empty(n)
    budget = counts[COUNT_STEPS] + options.chunk
    search, table = event_tables(model)
    watched = table.shape[1] > 0
    code = begin(model, work, run, y, slopes[0], table, options.max_events)
    if code != RUNNING:
        return code
    if adaptive and clock[CLOCK_H] == 0.0:
        clock[CLOCK_H] = first_step(
            model, work, clock[CLOCK_T], y, slopes[0], tableau.order, options.rtol, options.atol, times[-1] - times[0]
        )
        counts[COUNT_RHS] += 1
    rejected = False
    avoided = 0
    natural = 0.0  # the step that accuracy allows, while one is shortened to avoid a singular pose
    while counts[COUNT_OUTPUT] < times.shape[0]:
        t = clock[CLOCK_T]
        target = times[counts[COUNT_OUTPUT]]
        proposed = clock[CLOCK_H] if adaptive else options.step
        reach = target - t
        h, lands, searching = choose_step(proposed, reach, adaptive and natural == 0.0, search)
        t_new = target if lands else t + h
        if t_new == t and not searching:
            return STEP_TOO_SMALL
        restore = options.project and (rejected or regularity(work) < NEAR_SINGULAR)
        pivot = _stages(model, work, tableau, t, h, y, slopes, trial, restore, options.projection_tolerance)
        counts[COUNT_RHS] += stages - 1
        noisy_stage = adaptive and pivot < (NOISY_STAGE / options.rtol) ** (2.0 / 3.0)
        if adaptive and not searching:  # a shorter step than an accepted one needs no second judgement
            if restore:
                project(model, work, t_new, trial, options.projection_tolerance, STAGE_ITERATIONS)
            derivative(model, work, t_new, trial, slopes[stages])
            counts[COUNT_RHS] += 1
            error = _error_norm(
                model, work, tableau, slopes, h, y, trial, scratch, options.rtol, options.atol, restore
            )
            accepted, clock[CLOCK_H] = _resize(error, tableau.error_order, h, proposed, lands, rejected)
            rejected = not accepted
            if rejected:
                counts[COUNT_REJECTED] += 1
                if t + clock[CLOCK_H] == t or clock[CLOCK_H] < 1e-14 * (times[-1] - times[0]):
                    return STEP_TOO_SMALL if np.isfinite(error) else NON_FINITE
                continue
        code, clock[CLOCK_COMPLIANCE] = close_step(
            model, work, t_new, trial, h, options.project, options.projection_tolerance,
            options.stop_on_compliance, clock[CLOCK_COMPLIANCE],
        )  # fmt: skip
        if code == PROJECTION and adaptive and not searching:
            code = withdraw(run, t, h, times[-1] - times[0])
            rejected = True
            natural = 0.0
            if code == RUNNING:
                continue
        if code != RUNNING:
            return code
        verdict = 0
        if watched:
            verdict = watch(model, work, t, h, trial, search, table)
            if verdict == RETRY:
                if adaptive:
                    clock[CLOCK_H] = proposed
                continue
        pivot = regularity(work) if adaptive and options.project else 1.0
        noisy_end = pivot < (NOISY_PIVOT / options.rtol) ** (2.0 / 3.0)
        noisy = avoided < PATIENT_AVOIDED and (noisy_stage or noisy_end)
        if verdict != EVENT and (noisy or pivot < SINGULAR_PIVOT / options.rtol):
            avoided += 1
            if avoided > MOST_AVOIDED:
                return SINGULAR
            if lands:  # the output stands; the run itself goes on from before it
                record(run, trial, states, worst_per_time)
                if counts[COUNT_OUTPUT] == times.shape[0]:
                    return DONE
                continue
            natural = max(natural, clock[CLOCK_H])
            clock[CLOCK_H] = (AVOID if noisy_end else AVOID_STAGE) * h
            continue
        if natural > 0.0:
            clock[CLOCK_H] = natural
        natural = 0.0
        avoided = 0
        for k in range(n):
            y[k] = trial[k]
        clock[CLOCK_T] = t_new
        counts[COUNT_STEPS] += 1
        if verdict == EVENT:
            code = settle(model, work, t_new, y, table, run, options.max_events)
            if code != RUNNING:
                return code
        code = end_step(run, lands, y, times, states, worst_per_time, options.max_steps)
        if code != RUNNING:
            return code
        if adaptive and not options.project and not searching and verdict != EVENT:
            for k in range(n):
                slopes[0, k] = slopes[stages, k]  # first same as last
        else:
            derivative(model, work, t_new, y, slopes[0])
            counts[COUNT_RHS] += 1
        if counts[COUNT_STEPS] >= budget:
            return RUNNING
    return DONE


def stability_polynomial(tableau: Tableau) -> tuple[float, ...]:
    """Return the coefficients of R(z) = 1 + z b^T (I - z A)^-1 1, lowest power first."""
    power, coefficients = np.ones(len(tableau.b)), [1.0]
    for _ in range(len(tableau.b)):
        coefficients.append(float(tableau.b @ power))
        power = tableau.a @ power
    return tuple(coefficients)


def explicit(tableau: Tableau) -> Advance:
    """Return the leg-by-leg driver of a tableau."""

    def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
        def chunk(states: np.ndarray, worst: np.ndarray) -> int:
            return advance_explicit(system.model, system.work, tableau, options, run, y, times, states, worst)

        return run_chunks(chunk, options, run, y, times)

    return advance
