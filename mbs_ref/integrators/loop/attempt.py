"""One attempt at a step, common to the compiled loops: how far it goes, what speaks against it, how it is taken."""

from __future__ import annotations

from typing import NamedTuple

from mbs_ref.integrators.loop.events import EVENT, KEEP, settle, watch
from mbs_ref.integrators.loop.leg import (
    PROJECTION,
    RUNNING,
)
from mbs_ref.integrators.loop.step_control import choose_step, close_step, end_step, is_cut, withdraw
from mbs_ref.kernels.jit import inlined

WITHDRAWN = 3  # a verdict beside those of events: the step ended beyond the reach of a loop, and is to be shorter


class Attempt(NamedTuple):
    """One step as it is tried."""

    t: float  # s, where it starts
    t_new: float  # s, where it ends
    h: float  # s
    proposed: float  # s, before it was cut to meet an output or an event
    lands: bool  # ends at an output time
    searching: bool  # for an event, inside a step that was accepted before


@inlined
def next_attempt(options, run, outputs, evenly, search):
    """Choose the step: the proposed one, up to the next output time, or what the search for an event asks.

    A fixed step gives way to a proposed part of it.
    """
    t, target = run.t, outputs.times[-1 if options.dense else run.next_output]
    proposed = run.h if options.step == 0.0 or 0.0 < run.h < options.step else options.step
    h, lands, searching = choose_step(proposed, target - t, evenly, search)
    return Attempt(t, target if lands else t + h, h, proposed, lands, searching)


@inlined
def stands_still(attempt):
    """Return whether time does not move; a search for an event may ask for that."""
    return attempt.t_new == attempt.t and not attempt.searching


@inlined
def close_attempt(model, work, options, run, attempt, span, trial, search, table):
    """Restore the constraints at the step's end and look for events inside it; return code and verdict.

    An adaptive step that cannot be closed is withdrawn; `span` (s) is that of the leg. The papers' test |C| < h takes
    the method's own step: one cut short to meet an output or an event says nothing of the method, and may be nothing.
    """
    step = max(attempt.h, attempt.proposed)
    code, run.compliance = close_step(
        model, work, attempt.t_new, trial, step, options.project, options.projection_tolerance,
        options.stop_on_compliance, run.compliance,
    )  # fmt: skip
    if code == PROJECTION and options.step == 0.0 and not attempt.searching:
        return withdraw(run, attempt.t, attempt.h, span), WITHDRAWN
    if code != RUNNING or table.shape[1] == 0:
        return code, KEEP
    return code, watch(model, work, attempt.t, attempt.h, trial, search, table)


@inlined
def propose_again(options, run, attempt):
    """Take back the proposal of a step that an event cuts short: the step after the event starts from it."""
    if options.step == 0.0:
        run.h = attempt.proposed


@inlined
def take(model, work, options, run, attempt, verdict, y, trial, table, outputs):
    """Move y to the step's end, settle an event there, keep an output; return a status code."""
    for k in range(y.shape[0]):
        y[k] = trial[k]
    run.t = attempt.t_new
    run.steps += 1
    if attempt.lands and is_cut(attempt.proposed, attempt.h):
        run.cut += 1
    if verdict == EVENT:
        code = settle(model, work, attempt.t_new, y, table, run, options.max_events)
        if code != RUNNING:
            return code
    return end_step(run, attempt.lands, y, outputs.times, outputs.states, outputs.compliance, options.max_steps)
