"""Gragg-Bulirsch-Stoer extrapolation in any floating-point precision, for motions with and without branches."""

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.optimize import root_scalar

from cross_checks.truths.truth import EPS, NoConvergenceError, check_time

COLUMNS = 9  # order 18 at most
EASY = 5  # converged this early, the next step may be longer: twice the step takes some three columns more
SMALLEST_STEP = 1e-9  # s


def extrapolate(derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Integrate y' = derivative(t, y) from times[0]; return y at `times`, shape (n_t, n), in start's precision.

    Modified midpoint rule, substeps 2, 4, 6, ... (Hairer, Norsett & Wanner, Solving ODEs I, II.9).
    `tolerance` is relative to max(1, |y|). Raises NoConvergenceError with the time it failed at.
    """
    states = np.empty((len(times), len(start)), dtype=start.dtype)
    states[0] = y = start
    t, step = start.dtype.type(times[0]), start.dtype.type(0.05)
    for k, goal in enumerate(times[1:].astype(start.dtype), start=1):
        while t < goal:
            check_time(t)
            whole = step >= goal - t
            h = goal - t if whole else step
            y_next, columns = attempt(derivative, t, y, h, tolerance)
            if y_next is None:
                step = h / 2
                if step < SMALLEST_STEP:
                    raise NoConvergenceError(f"extrapolation stalls at t = {float(t):.6g} s")
                continue
            t, y = goal if whole else t + h, y_next
            step = max(step, 2 * h) if columns <= EASY else step
        states[k] = y
    return states


def attempt(derivative: Callable, t, y: np.ndarray, h, tolerance: float) -> tuple[np.ndarray | None, int]:
    """Return the state after one step and the columns it took; None where they do not converge."""
    row: list[np.ndarray] = []
    slope = derivative(t, y)
    scale = max(1.0, float(np.max(np.abs(y))))
    for j in range(COLUMNS):
        fresh = [_midpoint(derivative, t, y, slope, h, 2 * (j + 1))]
        for k in range(1, j + 1):
            ratio = (y.dtype.type(j + 1) / (j + 1 - k)) ** 2
            fresh.append(fresh[k - 1] + (fresh[k - 1] - row[k - 1]) / (ratio - 1))
        if j and np.max(np.abs(fresh[-1] - row[-1])) <= tolerance * scale:
            return fresh[-1], j + 1
        if not np.all(np.isfinite(fresh[-1])):
            break
        row = fresh
    return None, COLUMNS


def _midpoint(derivative: Callable, t, y: np.ndarray, slope: np.ndarray, h, substeps: int) -> np.ndarray:
    """The modified midpoint rule with Gragg's last step; its error has even powers of h only.

    The last step evaluates the derivative at the step's end (Hairer, Norsett & Wanner, II.9.13c): without it a force
    that sets in between the last two substeps would be seen by none of the columns.
    """
    small = h / substeps
    before, now = y, y + small * slope
    for k in range(1, substeps):
        before, now = now, before + 2 * small * derivative(t + k * small, now)
    return (before + now + small * derivative(t + h, now)) / 2


FIRST_STEP = 1e-3  # s
RESOLUTION = 1e-15  # s, to which a change of branch is located
MOST_CHANGES = 20_000
BRANCH_TOLERANCE = 1e-12  # of max(1, |y|): stiff forces leave some 1e-13 of roundoff in a step's last columns


def extrapolate_branches(
    frozen: Callable, switches: Callable, start: np.ndarray, times: np.ndarray, tolerance: float = BRANCH_TOLERANCE
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
                    raise NoConvergenceError(f"forces begin and end without limit at t = {t:.6g} s")
                t, y = t + h, ahead
                on = switches(t, y) > 0.0
                continue
            t, y = float(goal) if whole else t + h, ahead
            step = max(step, 2 * h) if columns <= EASY else step
        states[k] = y
    return states


def _cut(slope, switches, on, t, y, h, ahead, tolerance) -> tuple[float, np.ndarray]:
    """Return the first step after which a switch has changed, and the state there, by Brent's method."""
    past, changing = (h, ahead), (switches(t + h, ahead) > 0.0) != on

    def margin(step: float) -> float:
        """Return how far the nearest switch is from its change, negative beyond it and never 0."""
        nonlocal past
        there = ahead if step == h else y if step == 0.0 else attempt(slope, t, y, step, tolerance)[0]
        if there is None:
            raise NoConvergenceError(f"extrapolation stalls at t = {t:.6g} s")
        values = switches(t + step, there)
        changed = (values > 0.0) != on
        if not changed.any():
            return max(float(np.abs(values[changing]).min()), RESOLUTION)
        past = (step, there) if step < past[0] else past
        return -max(float(np.abs(values[changed]).max()), RESOLUTION)

    root_scalar(margin, bracket=(0.0, h), xtol=RESOLUTION, rtol=4.0 * EPS)
    return past
