"""Jacobi's amplitude in extended precision, and the rounding error of a closed form."""

from collections.abc import Callable

import numpy as np

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
DOUBLE_EPS = float(np.finfo(float).eps)


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
    return DOUBLE_EPS * float(np.sum(changes)) / NUDGE
