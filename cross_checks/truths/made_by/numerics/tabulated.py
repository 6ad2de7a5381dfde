"""Smooth functions of one number, interpolated in extended precision on pieces, each evaluated at its first use."""

from collections.abc import Callable

import numpy as np

from cross_checks.truths.truth import NoConvergenceError

NODES = 32  # of a piece, Chebyshev's of the first kind
WIDTH = 0.5  # of the longest pieces
SHORTEST = 2.0**-12  # of WIDTH; a piece that is not resolved is halved
RESOLVED = 64 * float(np.finfo(np.longdouble).eps)  # of a pair's largest value: the last terms of a piece's series

TURNS = (np.arange(NODES, dtype=np.longdouble) + 0.5) * (2 * np.arctan2(np.longdouble(1), np.longdouble(0)) / NODES)
POINTS = np.cos(TURNS)
WEIGHTS = np.sin(TURNS) * (-1.0) ** np.arange(NODES)
LAST_TERMS = np.cos(np.outer(np.arange(NODES - 4, NODES), TURNS)) * (2 / np.longdouble(NODES))


class Tabulated:
    """Pairs of values and derivatives (2 m,), by the barycentric formula (Berrut and Trefethen, SIAM Rev. 46 (2004)
    501, eq. 4.2).

    A call raises NoConvergenceError where pieces of SHORTEST do not resolve the function.
    """

    def __init__(self, function: Callable[[np.longdouble], np.ndarray]) -> None:
        self.function = function
        self.pieces: dict[tuple[float, int], np.ndarray | None] = {}  # by width and number; None where it is halved

    def __call__(self, s: np.longdouble) -> np.ndarray:
        width = WIDTH
        while (values := self._piece(width, int(np.floor(s / width)))) is None:
            width /= 2
        away = 2 * (s / width - np.floor(s / width)) - 1 - POINTS
        exact = np.flatnonzero(away == 0)
        if len(exact):
            return values[exact[0]]
        shares = WEIGHTS / away
        return shares @ values / shares.sum()

    def _piece(self, width: float, number: int) -> np.ndarray | None:
        if (width, number) not in self.pieces:
            if width < SHORTEST * WIDTH:
                raise NoConvergenceError(f"the mechanism's inertia is not smooth near {number * width:.6g}")
            places = (number + (POINTS + 1) / 2) * width
            values = np.array([self.function(place) for place in places])
            is_resolved = np.all(_sizes(LAST_TERMS @ values) <= RESOLVED * _sizes(values))
            self.pieces[width, number] = values if is_resolved else None
        return self.pieces[width, number]


def _sizes(values: np.ndarray) -> np.ndarray:
    """Return the largest number (m,) of every pair."""
    return np.abs(values).reshape(len(values), -1, 2).max(axis=(0, 2))
