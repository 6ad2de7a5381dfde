"""Closed forms in extended precision: Jacobi's amplitude, their rounding error, and integrals with an error bound."""

from collections.abc import Callable
from functools import cache

import numpy as np
import scipy

from cross_checks.truths.truth import EPS as EPS_DOUBLE
from cross_checks.truths.truth import NoConvergenceError, check_time

LEVELS = 8  # at most: the arithmetic-geometric mean doubles its digits at each
EPS = np.finfo(np.longdouble).eps  # relative; means that differ by two of it are equal


def amplitude(u: np.ndarray, m) -> np.ndarray:
    """Return am(u | m), rad, for 0 <= m < 1, in numpy's longdouble (Abramowitz & Stegun 16.4)."""
    means, ratios = _means(np.longdouble(m))
    phi = 2 ** len(ratios) * means * np.asarray(u, dtype=np.longdouble)
    for ratio in reversed(ratios):
        phi = (phi + np.arcsin(ratio * np.sin(phi))) / 2
    return phi


def quarter_period(m) -> np.longdouble:
    """Return K(m) in numpy's longdouble."""
    return np.arctan2(np.longdouble(1), np.longdouble(0)) / _means(np.longdouble(m))[0]


def _means(m) -> tuple[np.longdouble, list[np.longdouble]]:
    """The arithmetic-geometric mean of 1 and sqrt(1 - m), and c_n / a_n on the way."""
    a, b = np.longdouble(1), np.sqrt(1 - m)
    ratios = []
    for _ in range(LEVELS):
        if a - b <= 2 * EPS * a:
            break
        a, b, c = (a + b) / 2, np.sqrt(a * b), (a - b) / 2
        ratios.append(c / a)
    return a, ratios


def argument(phi, m) -> np.longdouble:
    """Return u with am(u | m) = phi (rad, in [-pi, pi]), 0 <= m < 1, in numpy's longdouble, by Newton's method."""
    phi, m = np.longdouble(phi), np.longdouble(m)
    u = phi * quarter_period(m) / quarter_period(np.longdouble(0))
    for _ in range(50):
        gap = phi - amplitude(np.asarray(u), m)
        u = u + gap / np.sqrt(1 - m * np.sin(phi) ** 2) / (2 if abs(gap) > 0.1 else 1)
    return u


NUDGE = 1e-10  # of each datum: the square of it is below the roundoff of extended precision
SAMPLED = 40  # times, of thousands


def rounding_error(
    motion: Callable[[np.ndarray, np.ndarray], np.ndarray], data: np.ndarray, times: np.ndarray
) -> float:
    """Return how far `motion(data, times)` changes where each of `data` (n,) changes by one rounding of a double.

    It is taken at some SAMPLED of the times, the last included, and NaN where a change of the data leaves the domain
    of the closed form.
    """
    few = times[::-1][:: 1 + len(times) // SAMPLED][::-1]
    steps = np.eye(len(data), dtype=np.longdouble) * NUDGE
    value = motion(data, few)
    with np.errstate(invalid="ignore", divide="ignore"):
        changes = [np.max(np.abs(motion(data * (1 + step), few) - value)) for step in steps]
    return EPS_DOUBLE * float(np.sum(changes)) / NUDGE


NODES = 24  # a piece; a sixteenth of a period needs fewer
MOST_PIECES = 200_000
TOLERANCE = 1e-17  # of a piece's integral between its value and that of its halves: some hundred roundoffs


def running_integral(
    rate: Callable[[np.ndarray], np.ndarray], times: np.ndarray, piece: float, tolerance: float = TOLERANCE
) -> tuple[np.ndarray, float]:
    """Return the integral of rate from 0 to each of `times` (s, increasing, >= 0), and a bound on its error.

    Pieces start `piece` s long or shorter. A piece is halved until the sum of its halves differs from it by no more
    than `tolerance`; the bound is the sum of these differences. Raises NoConvergenceError where there are too many.
    """
    ends = np.concatenate(([np.longdouble(0)], times))
    counts = np.ceil((np.diff(ends) / piece).astype(float))
    if not counts.sum() <= MOST_PIECES:
        raise NoConvergenceError(f"{counts.sum():.3g} pieces are too many for the quadrature; at most {MOST_PIECES}")
    owner = np.repeat(np.arange(len(times)), counts.astype(int))
    within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts.astype(int))
    width = (np.diff(ends) / np.fmax(counts, 1.0))[owner]
    lower = ends[owner] + within * width
    upper = np.where(within + 1 == counts[owner], ends[owner + 1], lower + width)
    whole, sums, doubt, spent = _gauss(rate, lower, upper), np.zeros(len(times), ends.dtype), 0.0, 0
    while len(owner):
        check_time(float(lower[0]))
        spent += len(owner)
        if spent > MOST_PIECES:
            raise NoConvergenceError(f"the quadrature does not converge near t = {float(lower[0]):.6g} s")
        middle = (lower + upper) / 2
        left, right = _gauss(rate, lower, middle), _gauss(rate, middle, upper)
        gap = np.abs(left + right - whole)
        coarse = ~(gap <= tolerance)
        np.add.at(sums, owner[~coarse], (left + right)[~coarse])
        doubt += float(gap[~coarse].sum())
        lower, upper = (np.concatenate((a[coarse], b[coarse])) for a, b in ((lower, middle), (middle, upper)))
        whole, owner = np.concatenate((left[coarse], right[coarse])), np.tile(owner[coarse], 2)
    return np.cumsum(sums), doubt


def _gauss(rate: Callable[[np.ndarray], np.ndarray], lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the Gauss-Legendre sum of each piece; the double-precision nodes are polished in extended precision."""
    x, w = legendre(NODES)
    nodes = (lower + upper)[:, None] / 2 + (upper - lower)[:, None] / 2 * x
    return (rate(nodes.ravel()).reshape(nodes.shape) @ w) * (upper - lower) / 2


def periodic_integral(
    rate: Callable[[np.ndarray], np.ndarray], times: np.ndarray, piece: float, period: np.longdouble
) -> tuple[np.ndarray, float]:
    """Return the running integral of a rate of known period (s), and its error: whole periods count once each."""
    turns = np.floor(times / period)
    if turns[-1] == 0:
        return running_integral(rate, times, piece)
    left = times - turns * period
    order = np.argsort(left)
    partial = np.empty_like(left)
    partial[order], rest = running_integral(rate, left[order], piece)
    whole, once = running_integral(rate, np.array([period]), piece)
    return turns * whole[0] + partial, rest + float(turns[-1]) * once


def integral(density: Callable[[float], float], start: float, end: float) -> tuple[float, float]:
    """Return an integral in double precision and QUADPACK's bound on its error. Raises NoConvergenceError."""
    value, doubt, _, *trouble = scipy.integrate.quad(density, start, end, epsabs=1e-15, epsrel=1e-13, full_output=1)
    if not np.isfinite(value) or (trouble and not doubt <= 1e-9 * abs(value)):
        raise NoConvergenceError(f"the quadrature does not converge: {trouble[0] if trouble else value}")
    return value, doubt


@cache
def legendre(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the n Gauss-Legendre nodes and weights of [-1, 1] in extended precision, by Newton's method."""
    x = np.polynomial.legendre.leggauss(n)[0].astype(np.longdouble)
    for _ in range(3):
        value, slope = _polynomial(n, x)
        x = x - value / slope
    return x, 2 / ((1 - x**2) * _polynomial(n, x)[1] ** 2)


def _polynomial(n: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the Legendre polynomial of degree n and its derivative; NumPy's legval divides in double precision."""
    before, now = np.ones_like(x), x
    for k in range(1, n):
        before, now = now, ((2 * k + 1) * x * now - k * before) / (k + 1)
    return now, n * (x * now - before) / (x**2 - 1)
