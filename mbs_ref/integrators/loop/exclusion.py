"""Exclude roots of event functions inside a step, or return where the first one may be.

A step's interpolant is cubic in the state, from the states and slopes at both ends, with a quartic term. That of the
positions makes their rates at a quarter and at three quarters those that the interpolated velocities mean. That of the
velocities makes the mean velocity the one that moves the positions from end to end. No stage of the method is needed.
An interval is halved until each function is excluded in it
- by a bound on its rate: a function cannot fall to zero in the time that its speed would need, as in conservative
  advancement (Mirtich, Impulse-based dynamic simulation, 1996, sec. 2.3);
- or by its second differences, once its rates confirm them, or they shrink as those of a smooth function do.
Neither holds for bodies that turn far: their intervals are halved until the turn is less than a radian.
What the quartic term changes in a function bounds the interpolant's error. Where a function is smaller than that, the
step is to end there, so that the method itself decides. Where that error is as large as the functions, as in a step
beyond the limit of stability, the interpolant shows nothing, and the step is halved.
"""

from typing import Any, NamedTuple

import numpy as np

from mbs_ref.kernels.border.questions import derivative, position_count, position_rate, rate_from, roots
from mbs_ref.kernels.contact.laws import LEFT_OUT, RATE, ROOTS_EACH, SPEED, TURN, VALUE
from mbs_ref.kernels.jit import bare, jit
from mbs_ref.kernels.rows import copy_rows

BEYOND = -1.0  # value of a function below which it is past its root
CLEAR = 2.0  # a place beyond the step: no root
DEEPEST = 30  # halvings of a step: no function is followed closer
FASTER = 2.0  # how many times its speed at both ends a function may reach between them
FAR_TURN, SMOOTH_TURN = 1.0, 2.0  # rad, turn in an interval to which the bounds on rates and the differences apply
SHRINKS = 0.5  # of second differences when intervals are halved: those of a smooth function shrink to a quarter
NOISE, SCATTER = 4.0, 1e-12  # roundoffs, and share of its size, by which a function may scatter between places
MOST_PLACES = 2000  # inside a step before it is cut short
TRUSTED = 0.2  # of a function's size in a step: the interpolant's error up to which it shows anything
FREEZE = -1.0  # s, duration with which pairs that are near stay as they are
QUARTER_SLOPE = 0.1875  # of s^2 (1 - s)^2 at s = 1/4
MEAN_QUARTIC = 1.0 / 30.0  # mean of s^2 (1 - s)^2


class Ends(NamedTuple):
    """States and slopes at both ends of a step."""

    y: Any  # (n,)
    dy: Any  # (n,)
    y_new: Any  # (n,)
    dy_new: Any  # (n,)
    known: Any  # (2,) 1 where a slope has been evaluated


class Path(NamedTuple):
    """The interpolant of a step."""

    t: float  # s
    h: float  # s
    ends: Ends
    bend: Any  # (n,) coefficients of s^2 (1 - s)^2


# Return the ends of a step whose slopes are unknown.
step_ends = jit(lambda y, dy, y_new, dy_new: Ends(y, dy, y_new, dy_new, np.zeros(2, dtype=np.int64)))


@jit
def first_open(model, work, t, h, ends, run, low, new):
    """Return the share of a step after which a function may be past its first root; CLEAR where none is.

    `low` and `new` (4, n) are the tables of functions at the step's ends.
    """
    unsure = _unsure(low, new, h)
    if not len(unsure):
        return CLEAR
    path = _path(model, work, t, h, ends, run, np.any(low[SPEED, unsure] < 0.0))
    return _search(model, work, path, unsure, low, new)


@jit
def _unsure(low, new, h):
    """Return the indices of the functions that no bound on their rates excludes over the whole step."""
    found, count = np.empty(low.shape[1], dtype=np.int64), 0
    for i in range(low.shape[1]):
        if not _is_far(low, new, i, h):
            found[count] = i
            count += 1
    return found[:count].copy()


@bare
def _is_far(left, right, i, width):
    """Return whether function i cannot fall to zero in an interval of this width (s), by the bound on its rate."""
    g0, g1 = left[VALUE, i] - BEYOND, right[VALUE, i] - BEYOND
    slow, fast = min(left[SPEED, i], right[SPEED, i]), max(left[SPEED, i], right[SPEED, i])
    if not min(g0, g1) >= 0.0 or slow < 0.0 or max(left[TURN, i], right[TURN, i]) * width > FAR_TURN:
        return False
    return g0 + g1 > FASTER * fast * width


@jit
def _path(model, work, t, h, ends, run, with_rates):
    """Return the interpolant; slopes that are not known are evaluated.

    `with_rates` states whether a function is more than a distance, so that the velocities have a quartic term too.
    """
    for place in range(2):
        if ends.known[place] == 0:
            y, dy = (ends.y, ends.dy) if place == 0 else (ends.y_new, ends.dy_new)
            derivative(model, work, t + place * h, y, dy)
            run.rhs_calls += 1
            ends.known[place] = 1
    n = position_count(model)
    path, state = Path(t, h, ends, np.zeros_like(ends.y)), np.empty_like(ends.y)
    rate, bend, mean = np.empty(n), np.zeros_like(ends.y), 7.0 * (ends.dy[:n] + ends.dy_new[:n])
    for sign, s in ((1.0, 0.25), (-1.0, 0.75)):
        _interpolate(path, s, state)
        position_rate(model, state, state[n:], rate)
        for k in range(n):
            rise = 6.0 * s * (1.0 - s) * (ends.y_new[k] - ends.y[k])
            slopes = (1.0 - s) * (1.0 - 3.0 * s) * ends.dy[k] + s * (3.0 * s - 2.0) * ends.dy_new[k]
            bend[k] += sign * (h * rate[k] - rise - h * slopes) / (2.0 * QUARTER_SLOPE)
            mean[k] += 32.0 * rate[k]
    path = Path(t, h, ends, bend)
    if with_rates:
        _bend_velocities(model, path, mean, state)
    return path


@jit
def _bend_velocities(model, path, mean, state):
    """Add the quartic term of the velocities; `mean` holds the rates of the positions by Boole's rule but the middle's.

    One larger than the cubic term shows errors of the method, not the motion.
    """
    ends, h, n = path.ends, path.h, len(mean)
    rate, missing = np.empty(n), np.empty(len(state) - n)
    _interpolate(path, 0.5, state)
    position_rate(model, state, state[n:], rate)
    for k in range(n):
        rate[k] = (ends.y_new[k] - ends.y[k]) / h - (mean[k] + 12.0 * rate[k]) / 90.0
    for k in range(len(missing)):
        missing[k] = 0.0
    rate_from(model, state, rate, missing)
    for k in range(len(missing)):
        most = 2.0 * h * abs(ends.dy_new[n + k] - ends.dy[n + k])
        path.bend[n + k] = min(max(missing[k] / MEAN_QUARTIC, -most), most)


@bare
def _interpolate(path, s, out):
    """Write the state at share s of the step."""
    ends, r = path.ends, 1.0 - s
    for k in range(out.shape[0]):
        value = (1.0 + 2.0 * s) * r * r * ends.y[k] + (3.0 - 2.0 * s) * s * s * ends.y_new[k]
        value += path.h * s * r * (r * ends.dy[k] - s * ends.dy_new[k])
        out[k] = value + (s * r) ** 2 * path.bend[k]


@jit
def _search(model, work, path, unsure, low, new):
    """Halve intervals from the left; return as `first_open` does."""
    most, count = DEEPEST + 3, len(unsure)
    tables, places = np.empty((most, 4, count)), np.empty(most)
    bends = np.full((most, count), np.inf)  # second differences of the interval twice as wide
    scratch, state = np.empty_like(new), np.empty_like(path.ends.y)
    _leave_out(unsure, scratch)
    _pick(low, unsure, tables[0])
    _pick(new, unsure, tables[1])
    places[0], places[1] = 0.0, 1.0
    error, is_trusted = _error(model, work, path, unsure, scratch, state, tables)
    if not is_trusted:
        return 1.0 if _is_past(tables[1]) else 0.5
    top = 1  # the interval is that from row 0 to row `top`; further right ends lie below
    for _ in range(MOST_PLACES):
        if top == 0:
            return CLEAR
        left, right = tables[0], tables[top]
        begin, width = places[0], places[top] - places[0]
        if not len(_unsure(left, right, width * path.h)):
            _advance(tables, places, top)
            top -= 1
            continue
        if width < 0.5**DEEPEST:
            if _is_past(right):
                return places[top]
            _advance(tables, places, top)
            top -= 1
            continue
        middle = begin + 0.5 * width
        if width < 1.0:
            _evaluate(model, work, path, middle, unsure, scratch, state, tables[top + 1])
        code = _examined(left, tables[top + 1], right, bends[top], error, middle, width, path.h)
        if code == EXCLUDED:
            _advance(tables, places, top)
            top -= 1
        elif code == HOLDS:
            return places[top]
        elif code == SMALL:
            return middle
        else:
            for c in range(count):
                bends[top, c] = bends[top + 1, c] = _second_difference(left, tables[top + 1], right, c)
            top += 1
            places[top] = middle
    return places[0] if places[0] > 0.0 else places[top]


EXCLUDED, HOLDS, SMALL, OPEN = range(4)


@bare
def _examined(left, middle, right, bends, error, place, width, h):
    """Return what three values of each function show: no root in an interval, one, values too small, or nothing."""
    answer = EXCLUDED
    past = _is_past(right)
    if _is_past(middle):
        return OPEN
    for c in range(left.shape[1]):
        if _is_far(left, right, c, width * h):
            continue
        half, turn = 0.5 * width * h, max(left[TURN, c], right[TURN, c]) * width * h
        bend = _bend(left, middle, right, c, half, bends[c])
        if turn > SMOOTH_TURN or bend == np.inf:
            return OPEN
        unsure = 16.0 * (place * (1.0 - place)) ** 2 * error[c]
        lowest = middle[VALUE, c]
        rises = left[RATE, c] * half >= 2.0 * bend and left[RATE, c] > 0.0
        falls = -right[RATE, c] * half >= 2.0 * bend and right[RATE, c] < 0.0
        falls = falls or right[VALUE, c] < BEYOND  # once: before the middle it has no other root
        if not rises:
            lowest = min(lowest, left[VALUE, c])
        if not falls:
            lowest = min(lowest, right[VALUE, c])
        if lowest - BEYOND < bend:
            return OPEN
        if middle[VALUE, c] - BEYOND <= unsure and unsure > NOISE:
            answer = SMALL
    return HOLDS if past else answer


@bare
def _second_difference(left, middle, right, c):
    """Return the absolute second difference of a function; 0 where it is roundoff."""
    g0, g1, g2 = left[VALUE, c], middle[VALUE, c], right[VALUE, c]
    return max(abs(g0 - 2.0 * g1 + g2) - NOISE - SCATTER * max(abs(g0), abs(g1), abs(g2)), 0.0)


@bare
def _bend(left, middle, right, c, half, before):
    """Return how far a smooth function can fall below three of its values; inf where it may not be smooth.

    It is smooth where its second difference is the one that its rates at both ends mean, or half of `before`, that of
    the wider interval, at most. Rates are of the interpolated velocities, which are not quite the derivative of the
    interpolated positions. Without their agreement the second difference, which may be small by chance, counts as a
    quarter of that before at least.
    """
    bend, r0, r1 = _second_difference(left, middle, right, c), left[RATE, c], right[RATE, c]
    if bend == 0.0:
        return 0.0
    apart = middle[VALUE, c] - 0.5 * (left[VALUE, c] + right[VALUE, c])
    if r0 != 0.0 and r1 != 0.0 and abs(apart - 0.25 * half * (r0 - r1)) <= 0.5 * SHRINKS * bend:
        return bend
    return max(bend, SHRINKS**2 * before) if before < np.inf and bend <= SHRINKS * before else np.inf


@bare
def _is_past(table):
    """Return whether a function is past its root."""
    past = False
    for value in table[VALUE]:
        past = past or not value >= BEYOND  # NaN too
    return past


@bare
def _advance(tables, places, top):
    """Begin the next interval where the last one ended."""
    copy_rows(tables[top], tables[0])
    places[0] = places[top]


@bare
def _leave_out(unsure, table):
    """Mark the sources without an unsure function."""
    table[SPEED] = 0.0
    for i in range(0, table.shape[1], ROOTS_EACH):
        table[SPEED, i] = LEFT_OUT
    for i in unsure:
        table[SPEED, i - i % ROOTS_EACH] = 0.0


@bare
def _evaluate(model, work, path, s, unsure, scratch, state, out):
    """Write the functions at share s of the step that are not excluded yet (4, count)."""
    _interpolate(path, s, state)
    roots(model, work, path.t + s * path.h, state, FREEZE, scratch)
    _pick(scratch, unsure, out)


@bare
def _pick(table, columns, out):
    """Write these columns of a table."""
    for c in range(len(columns)):
        for row in range(out.shape[0]):
            out[row, c] = table[row, columns[c]]


@jit
def _error(model, work, path, unsure, scratch, state, tables):
    """Return what the quartic term changes in each function in the middle of the step, and whether that is little.

    The functions there are row 2 of the tables, behind those at both ends.
    """
    is_trusted = True
    error, with_it, without = np.empty(len(unsure)), tables[2], np.empty((4, len(unsure)))
    cubic = Path(path.t, path.h, path.ends, np.zeros_like(path.bend))
    _evaluate(model, work, path, 0.5, unsure, scratch, state, with_it)
    _evaluate(model, work, cubic, 0.5, unsure, scratch, state, without)
    for c in range(len(unsure)):
        error[c] = abs(with_it[VALUE, c] - without[VALUE, c])
        size = max(abs(tables[0, VALUE, c]), abs(tables[1, VALUE, c]), abs(with_it[VALUE, c]))
        is_trusted = is_trusted and not error[c] > TRUSTED * size + NOISE
    return error, is_trusted
