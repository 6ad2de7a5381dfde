"""Taylor series of variable order for small planar trees and few particles, whose derivatives follow by recurrences.

The step makes the last terms as large as the tolerance: A. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99,
sec. 3. Their order counts the p^2 products of a step alone; what a step and an order cost besides makes a higher order
cheaper. No step is rejected. Outputs and events are values of the step's polynomial, so that neither shortens a step
nor costs an expansion. The state is that of relative coordinates, in which joints are always closed.
"""

from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from mbs_ref.cores.particles import nearest
from mbs_ref.cores.series import expansion_of, no_series
from mbs_ref.integrators.loop import leg
from mbs_ref.integrators.loop import step as stepping
from mbs_ref.integrators.loop.events import KEEP, RETRY, event_tables, has_events, watch_at
from mbs_ref.integrators.loop.exclusion import step_ends
from mbs_ref.kernels.algebra.dense import all_finite
from mbs_ref.kernels.jit import loop_jit, placed
from mbs_ref.kernels.series import MAX_ORDER, collided, evaluate, expand, largest_term, start_at, take_tolerances
from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from mbs_ref.cores.system import System


LOOKED_AT = 6  # terms that determine a step


@placed
def _longest_step(series, rtol, order):
    """Return the step (s) at which the last terms of no coordinate and no rate exceed the tolerances.

    From a start at rest every second term vanishes, and with weights alone three of four. Each of the last LOOKED_AT
    terms therefore counts, as if those behind it fell by rtol^(1/order) each, as they do in a step of this size.
    """
    step, fall, behind = np.inf, np.log(rtol) / order, 0.0  # logarithms
    for k in range(order, max(order - LOOKED_AT, 0), -1):
        size = largest_term(series, k)
        if size > 0.0:
            step = min(step, -(np.log(size) + behind) / k)
        behind += fall
    return np.exp(step)


@loop_jit
def advance_taylor(model, work, expanded, options, order, run, y, outputs):
    """Advance y through the output times, in place; return a status code (RUNNING when the chunk is used up)."""
    series = expanded.series
    dy, y_new, dy_new = np.empty_like(y), np.empty_like(y), np.empty_like(y)
    search, table = event_tables(model)
    ends, is_new = step_ends(y, dy, y_new, dy_new), True
    ends.known[:] = 1
    take_tolerances(series, options.atol)
    budget, last = run.steps + options.chunk, outputs.times.shape[0] - 1
    code = stepping.begin(model, work, options, run, y, dy, table)
    while code == leg.RUNNING and run.steps < budget:
        if is_new:
            start_at(series, y, options.rtol)
            expand(series, order)
            run.rhs_calls += 1
            run.h, is_new = _longest_step(series, options.rtol, order), False
        attempt = stepping.next_attempt(0.0, run, outputs.times[last], False, search)
        if stepping.stands_still(attempt):
            return leg.STEP_TOO_SMALL
        evaluate(series, order, attempt.h, y_new, dy_new)
        if not all_finite(y_new):
            return leg.NON_FINITE
        verdict = KEEP
        if has_events(table):
            verdict = watch_at(options.watch, model, work, attempt.t, attempt.h, ends, run, search, table)
            if verdict == RETRY:
                continue
        while run.next_output < last and outputs.times[run.next_output] <= attempt.t_new:
            now, place = outputs.times[run.next_output], outputs.states[run.next_output]
            evaluate(series, order, now - attempt.t, place, dy)
            if collided(series, place):
                run.t = now
                for k in range(y.shape[0]):
                    y[k] = place[k]
                return leg.COLLISION
            run.next_output += 1
        for k in range(dy.shape[0]):
            dy[k] = dy_new[k]
        code, is_new = stepping.accept(model, work, options, run, attempt, verdict, y, y_new, table, outputs), True
        if collided(series, y) and (code == leg.RUNNING or code == leg.DONE):
            return leg.COLLISION
    return code


MIN_ORDER = 4
PER_STEP, PER_ORDER = 150, 30  # products that cost as much as a step and an order do besides, measured on chains


@cache
def order_of(rtol: float) -> int:
    """Return the order p that costs least if the step is rtol^(1/p) of the radius of convergence."""
    return min(range(MIN_ORDER, MAX_ORDER + 1), key=lambda p: (PER_STEP + PER_ORDER * p + p * p) * rtol ** (-1.0 / p))


def advance(system: "System", options: leg.Options, run: leg.Progress, y: np.ndarray, times: np.ndarray) -> leg.Leg:
    """Advance a planar tree or particles over one leg."""
    series, order = expansion_of(system), order_of(options.rtol)
    own, is_full = series.system, series.system is not system
    state = own.reduced(y) if is_full else y
    chunk = partial(advance_taylor, own.model, own.work, series.handle, options, order, run, state)
    ended = leg.run_chunks(chunk, options, run, state, times)
    if ended.status is Status.COLLISION:
        ended.message += f": {nearest(own.scene, y)}"
    if is_full:
        states = np.empty((len(times), len(y)))
        states[: ended.reached] = own.all_full(ended.states[: ended.reached])
        ended.states, y[:] = states, own.full(state)
    return ended


METHOD = leg.Integrator(
    name="taylor",
    kind="adaptive",
    order=MAX_ORDER,
    varies_order=True,
    description="Taylor series of the order that suits the tolerance, adaptive, for small trees and few particles",
    advance=advance,
    stabilization="none",
    stabilizations=("none",),
    interpolates=True,
    prepare=expansion_of,
    refusals=no_series,
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13),
    source="Jorba, Zou, Experimental Mathematics 14 (2005) 99",
)
