"""Event location common to every compiled loop: shorten the step until it ends just past the first root.

A loop takes a step in the frozen modes and calls `watch`. It returns KEEP, RETRY with the step in search[H_NEXT], or
EVENT: the step at hand ends at the event, on its far side. A step is accepted where every event function is excluded
inside it (mbs_ref.integrators.loop.exclusion). The same one-step method is repeated with shorter steps, so the located
state has the method's own order.

Root functions come in units of their own roundoff. One that is negative by less than that is at its root: the
search aims between, at AIM, by the cubic through values and rates at both ends of its bracket, or regula falsi where
rates are unknown.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import from_dtype, types
from numba.core.typing.templates import signature

from mbs_ref.integrators.loop.exclusion import BEYOND, FREEZE, Ends, first_open
from mbs_ref.integrators.loop.leg import ENDLESS_EVENTS, PROGRESS, RUNNING, STOP_EVENT
from mbs_ref.kernels.border.calls import COUNT, MATRIX, MODEL, NUMBER, VECTOR, WORK, address_of, called_at
from mbs_ref.kernels.border.questions import root_count, roots, transition
from mbs_ref.kernels.contact.laws import RATE, TURNED, VALUE
from mbs_ref.kernels.contact.modes import STOP
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.rows import copy_rows

KEEP, RETRY, EVENT = range(3)
ACTIVE, H_LOW, H_HIGH, H_NEXT, SIDE, TRIES, WEIGHT_LOW, WEIGHT_HIGH = range(8)
IDLE, BRACKETED, LOOKING = 0.0, 1.0, 2.0  # values of search[ACTIVE]
AIM = -0.5  # of a function: in the middle of where it is no nearer to its root than its roundoff
MOST_TRIES = 200
ROUNDOFF = 4.0 * 2.220446049250313e-16  # of time: how closely an event is bracketed
MOST_ROUNDS = 200  # mode changes at one instant before they count as endless
BISECT_EVERY = 4  # tries: the others interpolate, regula falsi with Illinois' weights
NEWTON = 6  # iterations for the root of a cubic, each doubling its digits


class Tables(NamedTuple):
    """The event functions, (4, n) each: at the start of a step or of a bracket, at the bracket's end, at the step's."""

    low: Any
    high: Any
    new: Any


@jit
def event_tables(model):
    """Return the search state and the tables of event functions."""
    n = root_count(model)
    return np.zeros(8), Tables(np.zeros((4, n)), np.zeros((4, n)), np.zeros((4, n)))


# Return whether any function is watched.
has_events = jit(lambda table: table.low.shape[1] > 0)


@jit
def _count_negative(g):
    """Return how many functions are negative, and how many of them are reported."""
    negative, reported = 0, 0
    for value in g:
        negative += value < 0.0
        reported += value < 0.0 and value != TURNED
    return negative, reported


@jit
def settle(model, work, t, y, table, run, most):
    """Change modes until all hold at (t, y); refresh the table. Return RUNNING, STOP_EVENT or ENDLESS_EVENTS."""
    scratch = np.empty_like(y)
    for _ in range(MOST_ROUNDS):
        roots(model, work, t, y, 0.0, table.low)
        if _count_negative(table.low[VALUE])[0] == 0:
            return RUNNING
        code, run.event_source = transition(model, work, t, run.span, y, table.low[VALUE], scratch)
        run.events += _count_negative(table.low[VALUE])[1]
        if code == STOP:
            return STOP_EVENT
        if code != 0 or run.events > most:
            return ENDLESS_EVENTS
    return ENDLESS_EVENTS


@jit
def _falls(search, table, i, h):
    """Return where in (0, 1) of a bracket of width h function i is at AIM, by all that is known of it at both ends."""
    g0, r0 = table.low[VALUE, i] - AIM, table.low[RATE, i] * h
    g1, r1 = table.high[VALUE, i] - AIM, table.high[RATE, i] * h
    weighed = search[WEIGHT_LOW] * g0
    falsi = weighed / (weighed - search[WEIGHT_HIGH] * g1)
    if r0 == 0.0 or r1 == 0.0:
        return falsi
    a, b = 2.0 * (g0 - g1) + r0 + r1, -3.0 * (g0 - g1) - 2.0 * r0 - r1
    s = g0 / (g0 - g1)
    for _ in range(NEWTON):
        slope = r0 + s * (2.0 * b + s * 3.0 * a)
        if slope >= 0.0:
            return falsi
        s -= (g0 + s * (r0 + s * (b + s * a))) / slope
    return s


@jit
def _propose(search, table):
    """Choose the next trial step: where the earliest of the functions beyond their roots falls, or bisect."""
    low = search[H_LOW]
    width = search[H_HIGH] - low
    share = 1.0
    for i in range(table.high.shape[1]):
        if table.high[VALUE, i] < BEYOND:
            share = min(share, _falls(search, table, i, width))
    if int(search[TRIES]) % BISECT_EVERY == BISECT_EVERY - 1 or not 0.0 < share < 1.0:
        share = 0.5
    return low + share * width


@jit
def _open_bracket(search, table, h):
    """Start a search in (0, h]; the table holds the roots at both ends."""
    search[ACTIVE] = BRACKETED
    search[TRIES] = search[SIDE] = search[H_LOW] = 0.0
    search[WEIGHT_LOW] = search[WEIGHT_HIGH] = 1.0
    search[H_HIGH] = h
    copy_rows(table.new, table.high)


@jit
def _tighten(search, table, h, broken):
    """Move one end of the bracket to h; an end that stands still twice is weighed half (Illinois)."""
    side = 1.0 if broken else -1.0
    moved, still = (WEIGHT_HIGH, WEIGHT_LOW) if broken else (WEIGHT_LOW, WEIGHT_HIGH)
    search[H_HIGH if broken else H_LOW] = h
    search[moved] = 1.0
    if search[SIDE] == side:
        search[still] *= 0.5
    search[SIDE] = side
    if broken:
        copy_rows(table.new, table.high)
    else:
        copy_rows(table.new, table.low)


@jit
def give_up(model, work, t, y, search, table):
    """End a search without an event: another step is to begin at (t, y)."""
    search[ACTIVE] = IDLE
    roots(model, work, t, y, FREEZE, table.low)


@jit
def _keep(search, table):
    search[ACTIVE] = IDLE
    copy_rows(table.new, table.low)
    return KEEP


@jit
def watch(model, work, t, h, ends, run, search, table):
    """Judge a step of size h (s) from t between two ends."""
    if roots(model, work, t + h, ends.y_new, h, table.new) and search[ACTIVE] != BRACKETED:
        roots(model, work, t, ends.y, FREEZE, table.low)  # other pairs are near than at the start
    lowest = 0.0
    for value in table.new[VALUE]:
        lowest = np.minimum(lowest, value)  # NaN too
    broken = not lowest >= 0.0
    if search[ACTIVE] == BRACKETED:
        _tighten(search, table, h, broken)
    else:
        end = first_open(model, work, t, h, ends, run, table.low, table.new)
        if end < 1.0 and h * end > ROUNDOFF * abs(t) and t + h * end < t + h:
            search[ACTIVE] = LOOKING
            search[H_NEXT] = end * h
            return RETRY
        if not broken:
            return _keep(search, table)
        _open_bracket(search, table, h)
    search[TRIES] += 1.0
    if BEYOND <= lowest < 0.0:
        search[ACTIVE] = IDLE
        return EVENT
    narrow = search[H_HIGH] - search[H_LOW] <= ROUNDOFF * max(abs(t), search[H_HIGH])
    if not narrow and search[TRIES] <= MOST_TRIES:
        search[H_NEXT] = _propose(search, table)
        return RETRY
    if h == search[H_HIGH]:
        search[ACTIVE] = IDLE
        return EVENT
    search[H_NEXT] = search[H_HIGH]
    return RETRY


_TABLES = types.NamedUniTuple(MATRIX, 3, Tables)
ENDS = types.NamedTuple([VECTOR] * 4 + [types.Array(COUNT, 1, "C")], Ends)
RUN = from_dtype(PROGRESS)
_SETTLE = MODEL, WORK, NUMBER, VECTOR, _TABLES, RUN, COUNT
_WATCH = MODEL, WORK, NUMBER, NUMBER, ENDS, RUN, VECTOR, _TABLES
# The same, called by their addresses: compiled once for all loops, and only for a scene with event functions.
settle_at = called_at("settle_at(address, model, work, t, y, table, run, most)", COUNT, *_SETTLE)
watch_at = called_at("watch_at(address, model, work, t, h, ends, run, search, table)", COUNT, *_WATCH)


@cache
def event_code() -> tuple[int, int]:
    """Return the addresses of `settle` and `watch`; compile them, or load them from the disk, if need be."""
    return address_of(settle, signature(COUNT, *_SETTLE)), address_of(watch, signature(COUNT, *_WATCH))
