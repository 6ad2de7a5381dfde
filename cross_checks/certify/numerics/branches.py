"""Extrapolation of a motion with branches: a step is smooth, and ends where a force sets in or lets go."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from cross_checks.certify.numerics.extrapolation import EASY, SMALLEST_STEP, attempt
from cross_checks.certify.numerics.time_limit import check_time
from cross_checks.truth import NoConvergenceError

FIRST_STEP = 1e-3  # s
RESOLUTION = 1e-15  # s, to which a change of branch is located
MOST_CHANGES = 20_000
TOLERANCE = 1e-12  # of max(1, |y|): stiff forces leave some 1e-13 of roundoff in a step's last columns


def extrapolate_branches(
    frozen: Callable, switches: Callable, start: np.ndarray, times: np.ndarray, tolerance: float = TOLERANCE
) -> np.ndarray:
    """Integrate y' = frozen(t, y, on), on = switches(t, y) > 0 held within a step; return y at `times`, (n_t, n).

    A step in which a switch changes sign is cut just past the first change. NoConvergenceError where steps
    or branches do not come to an end.
    """
    states = np.empty((len(times), len(start)))
    states[0] = y = start
    t, step, changes = float(times[0]), FIRST_STEP, 0
    on = switches(t, y) > 0.0
    for k, goal in enumerate(times[1:], start=1):
        while t < goal:
            check_time(t)
            whole = step >= goal - t
            h = goal - t if whole else step
            slope = partial(frozen, on=on)
            ahead, columns = attempt(slope, t, y, h, tolerance)
            if ahead is None:
                step = h / 2
                if step < SMALLEST_STEP:
                    raise NoConvergenceError(f"extrapolation stalls at t = {t:.6g} s")
                continue
            if np.any((switches(t + h, ahead) > 0.0) != on):
                h, ahead = _cut(slope, switches, on, t, y, h, ahead, tolerance)
                changes += 1
                if changes > MOST_CHANGES:
                    raise NoConvergenceError(f"forces set in and let go without end at t = {t:.6g} s")
                t, y = t + h, ahead
                on = switches(t, y) > 0.0
                continue
            t, y = float(goal) if whole else t + h, ahead
            step = max(step, 2 * h) if columns <= EASY else step
        states[k] = y
    return states


def _cut(slope, switches, on, t, y, h, ahead, tolerance) -> tuple[float, np.ndarray]:
    """Bisect to the first step after which a switch has changed."""
    low = 0.0
    while h - low > RESOLUTION:
        middle = 0.5 * (low + h)
        there, _ = attempt(slope, t, y, middle, tolerance)
        if there is None:
            raise NoConvergenceError(f"extrapolation stalls at t = {t:.6g} s")
        if np.any((switches(t + middle, there) > 0.0) != on):
            h, ahead = middle, there
        else:
            low = middle
    return h, ahead
