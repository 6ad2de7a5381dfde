"""A Butcher tableau: an explicit Runge-Kutta method is data."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Tableau(NamedTuple):
    """Butcher coefficients; error rows weigh the stages and, last, the slope at the new point."""

    a: np.ndarray  # (s, s)
    b: np.ndarray  # (s,)
    c: np.ndarray  # (s,)
    error: np.ndarray  # (s + 1,) main error weights; empty for fixed-step methods
    error_low: np.ndarray  # (s + 1,) second estimate (DOP853), or empty
    order: int
    error_order: int


def stability_polynomial(tableau: Tableau) -> tuple[float, ...]:
    """Return the coefficients of R(z) = 1 + z b^T (I - z A)^-1 1, lowest power first."""
    power, coefficients = np.ones(len(tableau.b)), [1.0]
    for _ in range(len(tableau.b)):
        coefficients.append(float(tableau.b @ power))
        power = tableau.a @ power
    return tuple(coefficients)
