"""Event location common to every compiled loop: shorten the step until it ends just past the first root.

A loop takes a step in the frozen modes and asks `watch`. The answer is KEEP, RETRY with the step in
search[H_NEXT], or EVENT: the step at hand ends at the event, on its far side. The same one-step method is
repeated with shorter steps, so the located state carries the method's own order.

Root functions come in units of their own roundoff. One that is negative by less than that is at its root: the
search aims between, at AIM, by the cubic through values and rates at both ends of its bracket, or regula falsi where
rates are unknown.
"""

from __future__ import annotations

import numpy as np

from mbs_ref.integrators.loop.leg import ENDLESS_EVENTS, RUNNING, STOP_EVENT
from mbs_ref.kernels.border.questions import root_count, roots, transition
from mbs_ref.kernels.contact.modes import STOP
from mbs_ref.kernels.jit import jit

KEEP, RETRY, EVENT = range(3)
ACTIVE, H_LOW, H_HIGH, H_NEXT, SIDE, TRIES, WEIGHT_LOW, WEIGHT_HIGH = range(8)
IDLE, BRACKETED, LOOKING = 0.0, 1.0, 2.0  # values of search[ACTIVE]
AT_LOW, AT_HIGH, AT_NEW, RATE_LOW, RATE_HIGH, RATE_NEW = range(6)  # rows of the table of root functions
BEYOND, AIM = -1.0, -0.5  # of a function: no nearer to its root than its roundoff, and in the middle of that
MOST_TRIES = 200
ROUNDOFF = 4.0 * 2.220446049250313e-16  # of time: how closely an event is bracketed
MOST_ROUNDS = 200  # mode changes at one instant before they count as endless
BISECT_EVERY = 4  # tries: the others interpolate, regula falsi with Illinois' weights
NEWTON = 6  # iterations for the root of a cubic, each doubling its digits


@jit
def event_tables(model):
    """Return the search state and the table of root functions."""
    return np.zeros(8), np.zeros((6, root_count(model)))


@jit
def settle(model, work, t, y, table, run, most):
    """Change modes until all hold at (t, y); refresh the table. Return RUNNING, STOP_EVENT or ENDLESS_EVENTS."""
    scratch = np.empty_like(y)
    for _ in range(MOST_ROUNDS):
        roots(model, work, t, y, table[AT_LOW], table[RATE_LOW])
        broken = 0
        for i in range(table.shape[1]):
            if table[AT_LOW, i] < 0.0:
                broken += 1
        if broken == 0:
            return RUNNING
        run.events += broken
        code, contact = transition(model, work, t, run.span, y, table[AT_LOW], scratch)
        run.event_source = contact
        if code == STOP:
            return STOP_EVENT
        if code != 0 or run.events > most:
            return ENDLESS_EVENTS
    return ENDLESS_EVENTS


@jit
def _dips(g0, r0, g1, r1, h):
    """Return where in (0, 1) the tangents at both ends meet if that is BEYOND the root, else 1.

    A function that bends upwards lies above its tangents: where they meet higher it has no root inside. So bends the
    gap of bodies that push each other apart, and the larger of a gap and of an excess over open ends.
    """
    if not (r0 < 0.0 and r1 > 0.0):
        return 1.0
    s = (g1 - g0 - r1 * h) / ((r0 - r1) * h)
    return s if 0.0 < s < 1.0 and g0 + r0 * h * s < BEYOND else 1.0


@jit
def _falls(search, table, i, h):
    """Return where in (0, 1) of a bracket of width h function i is at AIM, by all that is known of it at both ends."""
    g0, r0 = table[AT_LOW, i] - AIM, table[RATE_LOW, i] * h
    g1, r1 = table[AT_HIGH, i] - AIM, table[RATE_HIGH, i] * h
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
    for i in range(table.shape[1]):
        if table[AT_HIGH, i] < BEYOND:
            share = min(share, _falls(search, table, i, width))
    if int(search[TRIES]) % BISECT_EVERY == BISECT_EVERY - 1 or not 0.0 < share < 1.0:
        share = 0.5
    return low + share * width


@jit
def _open_bracket(search, table, h):
    """Start a search in (0, h]; the table holds the roots at both ends."""
    search[ACTIVE] = BRACKETED
    search[TRIES] = 0.0
    search[SIDE] = 0.0
    search[WEIGHT_LOW] = 1.0
    search[WEIGHT_HIGH] = 1.0
    search[H_LOW] = 0.0
    search[H_HIGH] = h
    _copy(table, AT_NEW, AT_HIGH)
    _copy(table, RATE_NEW, RATE_HIGH)


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
    _copy(table, AT_NEW, AT_HIGH if broken else AT_LOW)
    _copy(table, RATE_NEW, RATE_HIGH if broken else RATE_LOW)


@jit
def _earliest_dip(table, h):
    dip = 1.0
    for i in range(table.shape[1]):
        dip = min(dip, _dips(table[AT_LOW, i], table[RATE_LOW, i], table[AT_NEW, i], table[RATE_NEW, i], h))
    return dip


@jit
def _keep(search, table):
    search[ACTIVE] = IDLE
    _copy(table, AT_NEW, AT_LOW)
    _copy(table, RATE_NEW, RATE_LOW)
    return KEEP


@jit
def watch(model, work, t, h, y, search, table):
    """Judge a step of size h from t that ended at y."""
    roots(model, work, t + h, y, table[AT_NEW], table[RATE_NEW])
    lowest = 0.0
    for i in range(table.shape[1]):
        lowest = np.minimum(lowest, table[AT_NEW, i])  # NaN too
    broken = not lowest >= 0.0
    if search[ACTIVE] == BRACKETED:
        _tighten(search, table, h, broken)
    elif broken:
        _open_bracket(search, table, h)
    else:
        dip = _earliest_dip(table, h)
        if dip == 1.0 or h <= ROUNDOFF * abs(t):
            return _keep(search, table)
        search[ACTIVE] = LOOKING  # a function may have been negative inside; end the step there and see
        search[H_NEXT] = dip * h
        return RETRY
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


@jit
def _copy(table, source, target):
    for i in range(table.shape[1]):
        table[target, i] = table[source, i]
