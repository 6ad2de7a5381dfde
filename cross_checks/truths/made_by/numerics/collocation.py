"""Gauss-Legendre collocation for y'' = f(t, y, y') in extended precision, with steps that its own series chooses."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from cross_checks.truths.truth import NoConvergenceError, check_time

STAGES = 14
MOST_SWEEPS = 60
SMALLEST_STEP = 1e-9  # s
ROUNDOFF = 4 * float(np.finfo(np.longdouble).eps)  # of a sweep


def collocate(
    acceleration: Callable, place: np.ndarray, rate: np.ndarray, times: np.ndarray, tolerance: float,
    seen: Callable[[np.ndarray], None] = lambda x: None,
) -> np.ndarray:  # fmt: skip
    """Return y (n_t, ...) at `times`; `acceleration` takes m instants at once: t (m,), y and y' (m, ...).

    The acceleration is a Legendre series over each step; a step holds where the last term of the series, times the
    step, is below `tolerance` of max(1, |y|, |y'|). That is the error of the stages; the end's is of twice the
    order where forces are smooth, and no worse where they are not. `seen` is given the stages (m, ...) of every
    step that holds. Raises NoConvergenceError.
    """
    result = np.empty((len(times), *place.shape), dtype=np.longdouble)
    result[0] = place
    t, step = np.longdouble(times[0]), np.longdouble(0.05)
    for k, goal in enumerate(times[1:].astype(np.longdouble), start=1):
        while t < goal:
            check_time(float(t))
            h = min(step, goal - t)
            stages, force, last = _attempt(acceleration, t, place, rate, h, tolerance)
            factor = min(2.0, 0.9 * (tolerance / max(last, 1e-30)) ** (1 / STAGES))
            if last > tolerance:
                step = h * max(0.1, factor)
                if step < SMALLEST_STEP:
                    raise NoConvergenceError(f"collocation stalls at t = {float(t):.6g} s")
                continue
            seen(stages)
            _, weights, double = coefficients()[:3]
            place = place + h * rate + h**2 * np.tensordot(double, force, axes=1)
            rate = rate + h * np.tensordot(weights, force, axes=1)
            step = max(step, h * factor) if h < step else h * factor
            t = goal if h == goal - t else t + h
        result[k] = place
    return result


def _attempt(acceleration, t, place, rate, h, tolerance) -> tuple[np.ndarray, np.ndarray, float]:
    """Return stages, their accelerations, and the size of the series' last term; infinite where sweeps do not end."""
    nodes, _, _, once, twice, highest = coefficients()
    shape = (-1, *(1,) * place.ndim)
    at = t + h * nodes
    moved = place + (h * nodes).reshape(shape) * rate
    scale = max(1.0, float(np.abs(place).max()), float(np.abs(rate).max()))
    force = np.zeros_like(moved)
    before = np.inf
    for _ in range(MOST_SWEEPS):
        stages = moved + h**2 * np.tensordot(twice, force, axes=1)
        new = acceleration(at, stages, rate + h * np.tensordot(once, force, axes=1))
        change, force = float(h * np.abs(new - force).max()), new
        if not change < 1e6 * scale:
            break
        if change <= ROUNDOFF * scale or (change >= before and change <= 1e3 * ROUNDOFF * scale):
            last = float(h * np.abs(np.tensordot(highest, force, axes=1)).max())
            return stages, force, last / scale
        before = change
    return stages, force, np.inf


@lru_cache(maxsize=1)
def coefficients() -> tuple[np.ndarray, ...]:
    """Return nodes c, weights b, b (1 - c), matrices A and A A, and what takes stages to the last Legendre term."""
    polynomial = np.polynomial.legendre
    s, top = STAGES, [0] * STAGES + [1]
    x = polynomial.leggauss(s)[0].astype(np.longdouble)
    for _ in range(3):  # Newton: from double to extended precision
        x = x - polynomial.legval(x, top) / polynomial.legval(x, polynomial.legder(top))
    weights = 1 / ((1 - x**2) * polynomial.legval(x, polynomial.legder(top)) ** 2)  # of [0, 1]
    values = np.array([polynomial.legval(x, [0] * n + [1]) for n in range(s + 1)], dtype=np.longdouble)
    # of a series sum a_n P_n: a_n = (2n + 1) sum_i b_i P_n(x_i) f_i; and int P_n = (P_(n+1) - P_(n-1)) / (2n + 1)
    analysis = (2 * np.arange(s, dtype=np.longdouble) + 1)[:, None] * values[:s] * weights
    integral = np.array([1 + x, *((values[n + 1] - values[n - 1]) / (2 * n + 1) for n in range(1, s))]) / 2
    once = integral.T @ analysis
    c = (1 + x) / 2
    return c, weights, weights * (1 - c), once, once @ once, analysis[-1]
