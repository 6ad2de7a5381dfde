"""The loop of Taylor series: the polynomial of an expansion gives the end of the step, the outputs and the events."""

import numpy as np

from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop import step as stepping
from mbs_ref.integrators.loop.events import KEEP, RETRY, event_tables, has_events, watch
from mbs_ref.integrators.loop.exclusion import step_ends
from mbs_ref.kernels.algebra.dense import all_finite
from mbs_ref.kernels.jit import loop_jit
from mbs_ref.kernels.relative.series import evaluate, expand, longest_step, start_at


@loop_jit
def advance_taylor(model, work, expanded, options, order, run, y, outputs):
    """Advance y through the output times, in place; return a status code (RUNNING when the chunk is used up)."""
    series = expanded.series
    dy, y_new, dy_new = np.empty_like(y), np.empty_like(y), np.empty_like(y)
    search, table = event_tables(model)
    ends, is_new = step_ends(y, dy, y_new, dy_new), True
    ends.known[:] = 1
    budget, last = run.steps + options.chunk, outputs.times.shape[0] - 1
    code = stepping.begin(model, work, run, y, dy, table, options.max_events)
    while code == leg.RUNNING and run.steps < budget:
        if is_new:
            start_at(series, y)
            expand(series, order)
            run.rhs_calls += 1
            run.h, is_new = longest_step(series, options.rtol, options.atol, order), False
        attempt = stepping.next_attempt(0.0, run, outputs.times[last], False, search)
        if stepping.stands_still(attempt):
            return leg.STEP_TOO_SMALL
        evaluate(series, order, attempt.h, y_new, dy_new)
        if not all_finite(y_new):
            return leg.NON_FINITE
        verdict = KEEP
        if has_events(table):
            verdict = watch(model, work, attempt.t, attempt.h, ends, run, search, table)
            if verdict == RETRY:
                continue
        while run.next_output < last and outputs.times[run.next_output] <= attempt.t_new:
            evaluate(series, order, outputs.times[run.next_output] - attempt.t, outputs.states[run.next_output], dy)
            run.next_output += 1
        dy[:] = dy_new
        code, is_new = stepping.accept(model, work, options, run, attempt, verdict, y, y_new, table, outputs), True
    return code
