"""Explicit Runge-Kutta methods, fixed-step or adaptive: their stages, one step with its error and outputs, the loop."""

from functools import cache, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import typeof, types
from numba.core.typing.templates import signature

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop import step as stepping
from mbs_ref.integrators.loop.events import ENDS, EVENT, RETRY, RUN, event_tables
from mbs_ref.integrators.loop.exclusion import step_ends
from mbs_ref.integrators.stages.tableau import RK4
from mbs_ref.kernels.algebra.dense import weighted_norm
from mbs_ref.kernels.border.calls import FLAG, MATRIX, MODEL, NOTHING, NUMBER, VECTOR, WORK, address_of, called_at
from mbs_ref.kernels.border.questions import derivative, project, regularity, tangent
from mbs_ref.kernels.jit import jit, loop_jit

if TYPE_CHECKING:
    from mbs_ref.cores.system import System
    from mbs_ref.integrators.stages.tableau import Tableau

STAGE_ITERATIONS = 6


class Stages(NamedTuple):
    """The arrays of a step; n is the size of the state."""

    slopes: np.ndarray  # (s + 1 + e, n) f at the stages, at the new state, and at the extra stages of dense output
    new: np.ndarray  # (n,) the new state
    scratch: np.ndarray  # (n,)


@jit
def fill_stages(model, work, tableau, t, h, y, stages, restore, tolerance):
    """Fill slopes[1:s]; slopes[0] is given. Leave the new state; return the worst stage's closure pivot.

    With `restore` every stage is first projected onto the constraints, to `tolerance`. Near a singular pose the
    accelerations off the manifold grow without bound while those on it stay smooth.
    """
    slopes, new = stages.slopes, stages.new
    pivot = 1.0
    for i in range(1, tableau.b.shape[0]):
        add_slopes(y, tableau.a[i], i, slopes, h, new)
        t_stage = t + tableau.c[i] * h
        if restore:
            project(model, work, t_stage, new, tolerance, STAGE_ITERATIONS)
        derivative(model, work, t_stage, new, slopes[i])
        pivot = min(pivot, regularity(work))
    add_slopes(y, tableau.b, tableau.b.shape[0], slopes, h, new)
    return pivot


@jit
def add_slopes(y, weights, count, slopes, h, out):
    """Write y + h sum w_j k_j over the first `count` slopes."""
    for k in range(out.shape[0]):
        out[k] = y[k]
    for j in range(count):
        weight = h * weights[j]
        if weight != 0.0:
            for k in range(out.shape[0]):
                out[k] += weight * slopes[j, k]


@jit
def _combine(weights, slopes, h, out):
    """Write h sum w_j k_j."""
    for k in range(out.shape[0]):
        out[k] = 0.0
    for j in range(weights.shape[0]):
        if weights[j] != 0.0:
            for k in range(out.shape[0]):
                out[k] += h * weights[j] * slopes[j, k]


@jit
def error_norm(model, work, tableau, h, y, stages, restore, pivot, rtol, atol):
    """Return the scaled error; with a second estimate as in DOP853 (Hairer, Norsett, Wanner I, sec. II.10).

    With `restore` projection removes the error off the constraints, which counts only as far as it exceeds what is
    `harmless` at the closure pivot of the worst stage: projection of a larger one may find another branch.
    """
    least = harmless(pivot, rtol) if restore else -1.0
    main = _estimate(model, work, tableau.error, h, y, stages, least, rtol, atol)
    if tableau.error_low.shape[0] == 0:
        return main
    low = _estimate(model, work, tableau.error_low, h, y, stages, least, rtol, atol)
    scale = main * main + 0.01 * low * low
    return 0.0 if scale == 0.0 else main * main / np.sqrt(scale)  # NaN must stay NaN, and be rejected


@jit
def _estimate(model, work, weights, h, y, stages, least, rtol, atol):
    """Return the scaled norm of one estimate; off the constraints what exceeds `least` counts, or all if that is -1."""
    _combine(weights, stages.slopes, h, stages.scratch)
    whole = weighted_norm(stages.scratch, y, stages.new, rtol, atol)
    if least < 0.0:
        return whole
    tangent(model, work, stages.scratch)
    return np.maximum(weighted_norm(stages.scratch, y, stages.new, rtol, atol), whole - least)


@jit
def _fill_between(model, work, tableau, tolerance, run, attempt, y, stages, ends, restore, outputs):
    """Fill the outputs inside an accepted step from y; where it lands on the last output, that one is left.

    Like a step's end, an output is put onto the constraints where steps are: `tolerance` is positive then.
    """
    end = outputs.times.shape[0] - 1 if attempt.lands else outputs.times.shape[0]
    first = run.next_output
    while run.next_output < end and outputs.times[run.next_output] <= attempt.t_new:
        if run.next_output == first:
            if ends.known[1] == 0:
                derivative(model, work, attempt.t_new, ends.y_new, ends.dy_new)
                run.rhs_calls += 1
                ends.known[1] = 1
            bumps = _bumps(model, work, tableau, attempt, y, stages, restore, tolerance)
            run.rhs_calls += tableau.dense.c.shape[0]
        place = run.next_output
        share = (outputs.times[place] - attempt.t) / attempt.h
        _interpolate(share, attempt.h, y, stages, tableau.b.shape[0], bumps, outputs.states[place])
        if tolerance > 0.0:
            project(model, work, outputs.times[place], outputs.states[place], tolerance, STAGE_ITERATIONS)
        stepping.record(run, outputs.states[place], outputs)


@jit
def _bumps(model, work, tableau, attempt, y, stages, restore, tolerance):
    """Evaluate the extra stages; return h D k (m, n)."""
    slopes, dense, last = stages.slopes, tableau.dense, tableau.b.shape[0]
    for i in range(dense.c.shape[0]):
        t_stage = attempt.t + dense.c[i] * attempt.h
        add_slopes(y, dense.a[i], last + 1 + i, slopes, attempt.h, stages.scratch)
        if restore:
            project(model, work, t_stage, stages.scratch, tolerance, STAGE_ITERATIONS)
        derivative(model, work, t_stage, stages.scratch, slopes[last + 1 + i])
    bumps = np.zeros((dense.d.shape[0], y.shape[0]))
    for m in range(dense.d.shape[0]):
        for j in range(slopes.shape[0]):
            weight = attempt.h * dense.d[m, j]
            if weight != 0.0:
                for k in range(y.shape[0]):
                    bumps[m, k] += weight * slopes[j, k]
    return bumps


@jit
def _interpolate(share, h, y, stages, last, bumps, out):
    """Write the state at a share of the step (Hairer, Norsett, Wanner I, eq. II.6.20 and their dop853.f)."""
    rest = 1.0 - share
    for k in range(y.shape[0]):
        way = stages.new[k] - y[k]
        leaning = h * stages.slopes[0, k] - way
        total = 0.0
        for m in range(bumps.shape[0] - 1, -1, -1):
            total = (total + bumps[m, k]) * (share if m % 2 == 1 else rest)
        total = (total + way - h * stages.slopes[last, k] - leaning) * share
        out[k] = y[k] + ((total + leaning) * rest + way) * share


_STAGES = types.NamedTuple([MATRIX, VECTOR, VECTOR], Stages)
_OUTPUTS = types.NamedTuple([VECTOR, MATRIX, VECTOR], leg.Outputs)
_ATTEMPT = types.NamedTuple([NUMBER] * 4 + [FLAG] * 2, stepping.Attempt)
_BETWEEN = MODEL, WORK, typeof(RK4), NUMBER, RUN, _ATTEMPT, VECTOR, _STAGES, ENDS, FLAG, _OUTPUTS
# The same, called by its address: compiled only where outputs are interpolated.
between_at = called_at(
    "between_at(address, model, work, tableau, tolerance, run, attempt, y, stages, ends, restore, outputs)",
    NOTHING, *_BETWEEN,
)  # fmt: skip


@cache
def between_code() -> int:
    """Return the address of `_fill_between`; compile it, or load it from the disk, if need be."""
    return address_of(_fill_between, signature(NOTHING, *_BETWEEN))


# Roundoff in an acceleration grows as eps / sigma^3 near a singular pose, with the relative closure pivot
# sigma^2. A step that ends where this harms the accuracy is shortened once, so that the next one
# passes over the pose; where that does not help it may end there, unless even positions would suffer. Where no shorter
# step avoids that either, the step that accuracy allows ends there if SHARPEST can be met: no tighter tolerance can be,
# next to such a pose.
NOISY_PIVOT = 2e-17  # over rtol, to the power 2/3
NOISY_STAGE = 1e-19  # likewise for a stage inside a step, whose weight is smaller
# A step's error off the constraints does not count up to so many times the roundoff that harms the accuracy, and this
# share of the way to the singular pose, beyond which projection finds another branch.
MAGNIFIED, WAY = 100.0, 1e-2
SINGULAR_PIVOT = 1e-17  # over rtol
SHARPEST = 1e-11  # rtol
TIGHTEST = 1e-13  # rtol that double precision can meet
PATIENT_AVOIDED, MOST_AVOIDED = 6, 60  # attempts in a row to end a step away from a singular pose
NEAR_SINGULAR = 0.1  # relative closure pivot below which stages are projected
AVOID_STAGE = 0.93  # step factor after a stage came too close to one
AVOID = 0.77  # step factor after ending too close to a singular pose


@jit
def accuracy(step, time, rtol, order):
    """Return rtol, or what a fixed step of the scene's time gives at the method's order."""
    return rtol if step == 0.0 else max(TIGHTEST, min(1.0, step / time) ** order)


# Return whether roundoff at a relative closure pivot harms the accuracy rtol.
is_noisy = jit(lambda pivot, limit, rtol: pivot < (limit / rtol) ** (2.0 / 3.0))


@jit
def is_too_near(pivot, stage_pivot, rtol, avoided, adaptive):
    """Return whether a step is not to end at this pivot, with its worst stage's; `avoided` attempts have not either."""
    noisy = is_noisy(pivot, NOISY_PIVOT, rtol) or is_noisy(stage_pivot, NOISY_STAGE, rtol)
    needed = rtol if avoided < MOST_AVOIDED else max(rtol, SHARPEST)
    return (noisy and avoided < PATIENT_AVOIDED) or (adaptive and pivot < SINGULAR_PIVOT / needed)


# Return how many tolerances of error off the constraints are harmless at a relative closure pivot.
harmless = jit(lambda pivot, rtol: (WAY * np.sqrt(pivot) + MAGNIFIED * NOISY_PIVOT / (pivot * np.sqrt(pivot))) / rtol)
# Return the step (s) in place of one that is not to end at this pivot, or had a stage too close to a singular pose.
shortened = jit(lambda h, pivot, rtol: h * (AVOID if is_noisy(pivot, NOISY_PIVOT, rtol) else AVOID_STAGE))
# Return the step (s) that accuracy allows, where no singular pose is near: `natural`, if one was stored.
resumed = jit(lambda h, natural: natural if natural > 0.0 else h)


@loop_jit
def advance_explicit(model, work, tableau, options, run, y, outputs):
    """Advance y through the output times, in place; return a status code (RUNNING when the chunk is used up).

    Near a singular pose a fixed step is divided there and then goes on with its own size.
    """
    adaptive, projects, tolerance = options.step == 0.0, options.project, options.projection_tolerance
    last, n, span = tableau.b.shape[0], y.shape[0], outputs.times[-1] - outputs.times[0]
    rtol = accuracy(options.step, options.time, options.rtol, tableau.order)
    stages = Stages(np.empty((last + 1 + tableau.dense.c.shape[0], n)), np.empty(n), np.empty(n))
    rejected, avoided, pivot = False, 0, 1.0
    natural = 0.0  # s, step that accuracy allows while one is shortened to avoid a singular pose, else 0
    search, table = event_tables(model)
    ends = step_ends(y, stages.slopes[0], stages.new, stages.slopes[last])
    budget = run.steps + options.chunk
    code = stepping.begin(model, work, options, run, y, stages.slopes[0], table)
    if code == leg.RUNNING and adaptive and run.h == 0.0:
        run.h = stepping.first_step(model, work, run.t, y, stages.slopes[0], tableau.order, options, span)
        run.rhs_calls += 1
    if not adaptive:
        run.h = options.step
    while code == leg.RUNNING and run.steps < budget:
        end = outputs.times[-1 if options.dense else run.next_output]
        attempt = stepping.next_attempt(options.step, run, end, adaptive and natural == 0.0, search)
        if stepping.stands_still(attempt):
            return leg.STEP_TOO_SMALL
        restore = projects and ((rejected and pivot < NEAR_SINGULAR) or regularity(work) < NEAR_SINGULAR)
        run.near_singular += 1 if restore else 0
        pivot = fill_stages(model, work, tableau, attempt.t, attempt.h, y, stages, restore, tolerance)
        run.rhs_calls += last - 1
        if adaptive and not attempt.searching:  # a shorter step than an accepted one needs no error estimate
            if restore:
                project(model, work, attempt.t_new, stages.new, tolerance, STAGE_ITERATIONS)
            if not projects:  # else where projection puts the step's end, once it is accepted
                derivative(model, work, attempt.t_new, stages.new, stages.slopes[last])
                run.rhs_calls += 1
            error = error_norm(model, work, tableau, attempt.h, y, stages, restore, pivot, options.rtol, options.atol)
            accepted, run.h = stepping.resized(
                error, tableau.error_order, attempt.h, attempt.proposed, attempt.lands, rejected
            )
            rejected = not accepted
            if rejected:
                run.rejected += 1
                if attempt.t + run.h == attempt.t or run.h < stepping.SHORTEST * span:
                    return leg.STEP_TOO_SMALL if np.isfinite(error) else leg.NON_FINITE
                continue
        ends.known[0], ends.known[1] = 1, adaptive and not projects and not attempt.searching
        code, verdict = stepping.close_attempt(model, work, options, run, attempt, span, ends, search, table)
        if verdict == stepping.WITHDRAWN:
            rejected, natural = True, 0.0
            continue
        if verdict == RETRY:
            if adaptive:
                run.h = attempt.proposed  # the step after the event starts from it
            continue
        if code != leg.RUNNING:
            return code
        there = regularity(work) if projects else 1.0
        avoids = is_too_near(there, pivot if restore else 1.0, rtol, avoided, adaptive) and verdict != EVENT
        if options.dense and (attempt.lands or not avoids):
            onto = tolerance if projects else 0.0
            between_at(options.between, model, work, tableau, onto, run, attempt, y, stages, ends, restore, outputs)
        if not avoids:
            run.h, natural, avoided = resumed(run.h, natural), 0.0, 0
            code = stepping.accept(model, work, options, run, attempt, verdict, y, stages.new, table, outputs)
            if code == leg.RUNNING and stepping.is_slope_known(ends, verdict):
                for k in range(n):
                    stages.slopes[0, k] = stages.slopes[last, k]
            elif code == leg.RUNNING:
                derivative(model, work, attempt.t_new, y, stages.slopes[0])
                run.rhs_calls += 1
            continue
        avoided += 1
        if avoided > MOST_AVOIDED:
            return leg.SINGULAR
        if attempt.lands:  # the output is stored, and the run goes on from before it
            stepping.record(run, stages.new, outputs)
            code = leg.DONE if run.next_output == outputs.times.shape[0] else leg.RUNNING
        else:
            natural = max(natural, run.h)
            run.h = natural if avoided == MOST_AVOIDED else shortened(attempt.h, there, rtol)
    return code


def explicit(tableau: "Tableau") -> leg.Advance:
    """Return the leg-by-leg driver of a tableau."""

    def advance(system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
        chunk = partial(advance_explicit, system.model, system.work, tableau, options, run, y)
        return leg.run_chunks(chunk, options, run, y, times)

    return advance
