"""All roots of a function on an interval, by subdivision with a bound on its second derivative."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

# (times, half widths) -> value, slope, and a bound on |second derivative| within the half width; each (n,)
Bounded = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]

PIECES = 32  # that an interval is cut into at first
SMALLEST = 1e-15  # half width, of the interval's end: a piece that is still undecided has a root within roundoff


class Undecided(ValueError):
    """Whether an event occurs depends on roundoff."""


def roots(function: Bounded, start: float, end: float) -> list[tuple[float, int]]:
    """Return the roots (s) between `start` and `end` in order, each with the sign of the slope.

    A piece is free of roots where |f(m)| > |f'(m)| h + M h^2 / 2, and has one at most where |f'(m)| > M h; m is its
    middle, h its half width and M the bound. Other pieces are halved. Raises Undecided at a root of even order.
    """
    if not end > start:
        return []
    edges = np.linspace(start, end, PIECES + 1)
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    brackets: list[tuple[float, float]] = []
    while len(middle):
        value, slope, bound = function(middle, half)
        possible = np.abs(value) <= np.abs(slope) * half + 0.5 * bound * half**2
        monotone = possible & (np.abs(slope) > bound * half)
        brackets += zip(middle[monotone] - half[monotone], middle[monotone] + half[monotone], strict=True)
        divided = possible & ~monotone
        middle, half = np.repeat(middle[divided], 2), 0.5 * np.repeat(half[divided], 2)
        middle[::2] -= half[::2]
        middle[1::2] += half[1::2]
        if np.any(half < SMALLEST * abs(end)):
            raise Undecided(f"a root of even order at {middle[np.argmin(half)]:.17g} s")
    return _refined(function, sorted(brackets))


def _refined(function: Bounded, brackets: list[tuple[float, float]]) -> list[tuple[float, int]]:
    if not brackets:
        return []
    low, high = (function(np.array(side), np.zeros(len(brackets)))[0] for side in zip(*brackets, strict=True))

    def scalar(time: float) -> float:
        return float(function(np.array([time]), np.zeros(1))[0][0])

    return [
        (float(brentq(scalar, *bracket, xtol=1e-300, rtol=4.0 * np.finfo(float).eps)), int(np.sign(after)))  # type: ignore[arg-type]
        for bracket, before, after in zip(brackets, low, high, strict=True)
        if before * after < 0.0
    ]
