"""Jacobi's amplitude in extended precision."""

from __future__ import annotations

import numpy as np

LEVELS = 8  # the arithmetic-geometric mean doubles its digits at each


def amplitude(u: np.ndarray, m) -> np.ndarray:
    """Return am(u | m), rad, for 0 <= m < 1, in numpy's longdouble (Abramowitz & Stegun 16.4)."""
    means, ratios = _means(np.longdouble(m))
    phi = 2**LEVELS * means * np.asarray(u, dtype=np.longdouble)
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
