"""Integrals of smooth rates over long times, by Gauss-Legendre pieces in extended precision."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cross_checks.certify.numerics.extrapolation import NoConvergenceError

NODES = 24  # a piece; a sixteenth of a period needs fewer
MOST_PIECES = 200_000


def running_integral(rate: Callable[[np.ndarray], np.ndarray], times: np.ndarray, piece: float) -> np.ndarray:
    """Return the integral of rate from 0 to each of `times` (s, increasing, >= 0); pieces are `piece` s or shorter.

    Nodes are double-precision Gauss-Legendre ones polished in extended precision. NoConvergenceError where
    there would be too many pieces.
    """
    total = float(times[-1])
    if total / piece > MOST_PIECES:
        raise NoConvergenceError(f"{total / piece:.3g} pieces are too many for the quadrature; at most {MOST_PIECES}")
    edges = [np.longdouble(0)]
    owner: list[int] = []
    for k, end in enumerate(times):
        start = edges[-1]
        count = int(np.ceil(float(end - start) / piece))
        owner += [k] * count
        edges += [start + (np.longdouble(end) - start) * j / count for j in range(1, count + 1)]
    if not owner:
        return np.zeros(len(times), dtype=np.longdouble)
    x, w = _legendre()
    lower, upper = np.array(edges[:-1]), np.array(edges[1:])
    nodes = (lower + upper)[:, None] / 2 + (upper - lower)[:, None] / 2 * x
    pieces = (rate(nodes.ravel()).reshape(nodes.shape) @ w) * (upper - lower) / 2
    sums = np.zeros(len(times), dtype=np.longdouble)
    np.add.at(sums, owner, pieces)
    return np.cumsum(sums)


def periodic_integral(
    rate: Callable[[np.ndarray], np.ndarray], times: np.ndarray, piece: float, period: np.longdouble
) -> np.ndarray:
    """Return the running integral of a rate of known period (s): whole periods count, the rest is integrated."""
    turns = np.floor(times / period)
    if turns[-1] == 0:
        return running_integral(rate, times, piece)
    left = times - turns * period
    order = np.argsort(left)
    partial = np.empty_like(left)
    partial[order] = running_integral(rate, left[order], piece)
    return turns * running_integral(rate, np.array([period]), piece)[0] + partial


def _legendre() -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights on [-1, 1] in extended precision: Newton's step on the double-precision nodes."""
    x = np.polynomial.legendre.leggauss(NODES)[0].astype(np.longdouble)
    for _ in range(2):
        value, slope = _polynomial(x)
        x = x - value / slope
    return x, 2 / ((1 - x**2) * _polynomial(x)[1] ** 2)


def _polynomial(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the Legendre polynomial of degree NODES and its derivative."""
    before, now = np.ones_like(x), x
    for n in range(1, NODES):
        before, now = now, ((2 * n + 1) * x * now - n * before) / (n + 1)
    return now, NODES * (x * now - before) / (x**2 - 1)
