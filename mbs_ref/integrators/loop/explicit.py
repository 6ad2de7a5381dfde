"""Explicit Runge-Kutta methods, fixed-step or adaptive: one step, and the loop over steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop import step as stepping
from mbs_ref.integrators.loop.events import EVENT, RETRY, event_tables
from mbs_ref.integrators.loop.exclusion import step_ends
from mbs_ref.integrators.stages.explicit_stages import STAGE_ITERATIONS, Stages, error_norm, fill_between, fill_stages
from mbs_ref.kernels.border.questions import derivative, project, regularity
from mbs_ref.kernels.jit import jit, loop_jit

if TYPE_CHECKING:
    from mbs_ref.cores.system import System
    from mbs_ref.integrators.stages.tableau import Tableau

# Roundoff in an acceleration grows as eps / sigma^3 near a singular pose, with the relative closure pivot
# sigma^2. A step that ends where this harms the accuracy is shortened once, so that the next one
# passes over the pose; where that does not help it may end there, unless even positions would suffer.
NOISY_PIVOT = 2e-17  # over rtol, to the power 2/3
NOISY_STAGE = 1e-19  # likewise for a stage inside a step, whose weight is smaller
SINGULAR_PIVOT = 1e-17  # over rtol
TIGHTEST = 1e-13  # rtol that double precision can meet
PATIENT_AVOIDED, MOST_AVOIDED = 6, 60  # attempts in a row to end a step away from a singular pose
NEAR_SINGULAR = 0.1  # relative closure pivot below which stages are projected
AVOID_STAGE = 0.93  # step factor after a stage came too close to one
AVOID = 0.77  # step factor after ending too close to a singular pose


@jit
def accuracy(step, time, rtol, order):
    """Return rtol, or what a fixed step of the scene's time gives at the method's order."""
    return rtol if step == 0.0 else max(TIGHTEST, min(1.0, step / time) ** order)


@jit
def is_noisy(pivot, limit, rtol):
    """Return whether roundoff at a relative closure pivot harms the accuracy rtol."""
    return pivot < (limit / rtol) ** (2.0 / 3.0)


@jit
def is_too_near(pivot, stage_pivot, rtol, avoided, adaptive):
    """Return whether a step is not to end at this pivot, with its worst stage's; `avoided` attempts have not either."""
    noisy = is_noisy(pivot, NOISY_PIVOT, rtol) or is_noisy(stage_pivot, NOISY_STAGE, rtol)
    return (noisy and avoided < PATIENT_AVOIDED) or (adaptive and pivot < SINGULAR_PIVOT / rtol)


@jit
def resumed(h, natural):
    """Return the step (s) that accuracy allows, where no singular pose is near: `natural`, if one was stored."""
    return natural if natural > 0.0 else h


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
    code = stepping.begin(model, work, run, y, stages.slopes[0], table, options.max_events)
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
            error = error_norm(model, work, tableau, attempt.h, y, stages, restore, options.rtol, options.atol)
            accepted, run.h = stepping.resized(
                error, tableau.error_order, attempt.h, attempt.proposed, attempt.lands, rejected
            )  # fmt: skip
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
            fill_between(model, work, tableau, options, run, attempt, y, stages, ends, restore, outputs)
        if not avoids:
            run.h, natural, avoided = resumed(run.h, natural), 0.0, 0
            code = stepping.accept(model, work, options, run, attempt, verdict, y, stages.new, table, outputs)
            if code == leg.RUNNING and stepping.is_slope_known(ends, verdict):
                stages.slopes[0, :] = stages.slopes[last]
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
            run.h = attempt.h * (AVOID if is_noisy(there, NOISY_PIVOT, rtol) else AVOID_STAGE)
    return code


def explicit(tableau: Tableau) -> leg.Advance:
    """Return the leg-by-leg driver of a tableau."""

    def advance(system: System, options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
        def chunk(outputs: leg.Outputs) -> int:
            return advance_explicit(system.model, system.work, tableau, options, run, y, outputs)

        return leg.run_chunks(chunk, options, run, y, times)

    return advance
