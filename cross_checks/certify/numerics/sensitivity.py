"""How a closed form magnifies the rounding of its data."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

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
