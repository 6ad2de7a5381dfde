"""Explicit Runge-Kutta methods, fixed-step or adaptive: the loop over steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbs_ref.integrators.loop.attempt import WITHDRAWN, close_attempt, next_attempt, propose_again, stands_still, take
from mbs_ref.integrators.loop.events import EVENT, RETRY, event_tables
from mbs_ref.integrators.loop.leg import (
    DONE,
    NON_FINITE,
    RUNNING,
    SINGULAR,
    STEP_TOO_SMALL,
    Advance,
    Leg,
    Options,
    Outputs,
    Progress,
    run_chunks,
)
from mbs_ref.integrators.loop.step_control import SHORTEST, begin, propose_first, record
from mbs_ref.integrators.stages.dense_output import fill_between
from mbs_ref.integrators.stages.explicit_stages import STAGE_ITERATIONS, Stages, error_norm, fill_stages
from mbs_ref.kernels.border.questions import derivative, project, regularity
from mbs_ref.kernels.jit import inlined, jit, loop_jit

if TYPE_CHECKING:
    from mbs_ref.cores.system import System
    from mbs_ref.integrators.stages.tableau import Tableau

# Roundoff in an acceleration grows as eps / sigma^3 near a singular pose, with the relative closure pivot
# sigma^2. A step that ends where this harms the asked accuracy is shortened once, so that the next one
# passes over the pose; where that does not help it may end there, unless even positions would suffer.
NOISY_PIVOT = 2e-17  # over rtol, to the power 2/3
NOISY_STAGE = 1e-19  # likewise for a stage inside a step, whose weight is smaller
SINGULAR_PIVOT = 1e-17  # over rtol
TIGHTEST = 1e-13  # accuracy that double precision allows to ask for
PATIENT_AVOIDED, MOST_AVOIDED = 6, 60  # attempts in a row to end a step away from a singular pose
NEAR_SINGULAR = 0.1  # relative closure pivot below which stages are projected
AVOID_STAGE = 0.93  # step factor after a stage came too close to one
AVOID = 0.77  # step factor after ending too close to a singular pose
SAFETY, SHRINK, GROW = 0.9, 0.2, 6.0  # step factors (Hairer, Norsett, Wanner I, sec. II.4)


class Past(NamedTuple):
    """What an attempt leaves to the next one."""

    natural: np.ndarray  # (1,) s, step that accuracy allows while one is shortened to avoid a singular pose, else 0
    marks: np.ndarray  # (2,) int: REJECTED, AVOIDED
    pivot: np.ndarray  # (1,) the worst closure pivot of its stages


REJECTED = 0  # 1 after a step whose error was too large
AVOIDED = 1  # attempts in a row that ended too close to a singular pose


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


@inlined
def _judge(model, work, tableau, options, run, attempt, span, y, stages, restore, past):
    """Propose the next step by this one's error; return a status code, and leave in `past` whether it is rejected."""
    last = tableau.b.shape[0]
    if restore:
        project(model, work, attempt.t_new, stages.new, options.projection_tolerance, STAGE_ITERATIONS)
    derivative(model, work, attempt.t_new, stages.new, stages.slopes[last])
    run.rhs_calls += 1
    error = error_norm(model, work, tableau, options, attempt.h, y, stages, restore)
    accepted, run.h = resized(
        error, tableau.error_order, attempt.h, attempt.proposed, attempt.lands, past.marks[REJECTED] == 1
    )
    past.marks[REJECTED] = 0 if accepted else 1
    if accepted:
        return RUNNING
    run.rejected += 1
    if attempt.t + run.h == attempt.t or run.h < SHORTEST * span:
        return STEP_TOO_SMALL if np.isfinite(error) else NON_FINITE
    return RUNNING


@inlined
def _asked(tableau, options):
    """Return the accuracy that is asked: rtol, or what a fixed step of the scene's time gives at the method's order."""
    if options.step == 0.0:
        return options.rtol
    return max(TIGHTEST, min(1.0, options.step / options.time) ** tableau.order)


@inlined
def _is_too_near(work, options, rtol, stage_pivot, past):
    """Return whether roundoff near a singular pose harms the asked accuracy, and whether it is the step's end there.

    A fixed step is divided there and then goes on as asked, be the pose what it may.
    """
    pivot = regularity(work) if options.project else 1.0
    noisy_stage = stage_pivot < (NOISY_STAGE / rtol) ** (2.0 / 3.0)
    noisy_end = pivot < (NOISY_PIVOT / rtol) ** (2.0 / 3.0)
    noisy = past.marks[AVOIDED] < PATIENT_AVOIDED and (noisy_stage or noisy_end)
    return noisy or (options.step == 0.0 and pivot < SINGULAR_PIVOT / rtol), noisy_end


@inlined
def _avoid(run, attempt, new, outputs, noisy_end, past):
    """Do not go on from here: propose a shorter step, or keep the output and go on from before it; return a code."""
    past.marks[AVOIDED] += 1
    if past.marks[AVOIDED] > MOST_AVOIDED:
        return SINGULAR
    if attempt.lands:
        record(run, new, outputs.states, outputs.compliance)
        return DONE if run.next_output == outputs.times.shape[0] else RUNNING
    past.natural[0] = max(past.natural[0], run.h)
    run.h = (AVOID if noisy_end else AVOID_STAGE) * attempt.h
    return RUNNING


@inlined
def _settle_down(run, past):
    """Go back to the step that accuracy allows: no singular pose is near."""
    if past.natural[0] > 0.0:
        run.h = past.natural[0]
    past.natural[0] = 0.0
    past.marks[AVOIDED] = 0


@inlined
def _next_slope(model, work, options, run, attempt, verdict, y, slopes, last):
    """Leave f at the new state in slopes[0]: where nothing moved the state, it is that of the last stage."""
    if options.step == 0.0 and not options.project and not attempt.searching and verdict != EVENT:
        for k in range(y.shape[0]):
            slopes[0, k] = slopes[last, k]
        return
    derivative(model, work, attempt.t_new, y, slopes[0])
    run.rhs_calls += 1


@loop_jit
def advance_explicit(model, work, tableau, options, run, y, outputs):
    """Advance y through the output times, in place; return a status code (RUNNING when the chunk is used up)."""
    adaptive, n, asked = options.step == 0.0, y.shape[0], _asked(tableau, options)
    span = outputs.times[-1] - outputs.times[0]
    stages = Stages(np.empty((tableau.b.shape[0] + 1 + tableau.dense.c.shape[0], n)), np.empty(n), np.empty(n))
    past = Past(np.zeros(1), np.zeros(2, dtype=np.int64), np.ones(1))
    search, table = event_tables(model)
    budget = run.steps + options.chunk
    code = begin(model, work, run, y, stages.slopes[0], table, options.max_events)
    if code != RUNNING:
        return code
    propose_first(model, work, options, run, y, stages.slopes[0], tableau.order, span)
    if not adaptive:
        run.h = options.step
    while code == RUNNING and run.steps < budget:
        attempt = next_attempt(options, run, outputs, adaptive and past.natural[0] == 0.0, search)
        if stands_still(attempt):
            return STEP_TOO_SMALL
        was_near = past.marks[REJECTED] == 1 and past.pivot[0] < NEAR_SINGULAR
        restore = options.project and (was_near or regularity(work) < NEAR_SINGULAR)
        past.pivot[0] = fill_stages(model, work, tableau, options, attempt.t, attempt.h, y, stages, restore)
        run.rhs_calls += tableau.b.shape[0] - 1
        if adaptive and not attempt.searching:  # a shorter step than an accepted one needs no second judgement
            code = _judge(model, work, tableau, options, run, attempt, span, y, stages, restore, past)
            if past.marks[REJECTED] == 1:
                continue
        code, verdict = close_attempt(model, work, options, run, attempt, span, stages.new, search, table)
        if verdict == WITHDRAWN:
            past.marks[REJECTED], past.natural[0] = 1, 0.0
            continue
        if verdict == RETRY:
            propose_again(options, run, attempt)
            continue
        if code != RUNNING:
            return code
        too_near, noisy_end = _is_too_near(work, options, asked, past.pivot[0] if restore else 1.0, past)
        avoids = too_near and verdict != EVENT
        if options.dense and (attempt.lands or not avoids):
            fill_between(model, work, tableau, options, run, attempt, y, stages, restore, outputs)
        if avoids:
            code = _avoid(run, attempt, stages.new, outputs, noisy_end, past)
            continue
        _settle_down(run, past)
        code = take(model, work, options, run, attempt, verdict, y, stages.new, table, outputs)
        if code == RUNNING:
            _next_slope(model, work, options, run, attempt, verdict, y, stages.slopes, tableau.b.shape[0])
    return code


def explicit(tableau: Tableau) -> Advance:
    """Return the leg-by-leg driver of a tableau."""

    def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
        def chunk(outputs: Outputs) -> int:
            return advance_explicit(system.model, system.work, tableau, options, run, y, outputs)

        return run_chunks(chunk, options, run, y, times)

    return advance
