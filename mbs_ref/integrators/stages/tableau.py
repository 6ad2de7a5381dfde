"""A Butcher tableau: an explicit Runge-Kutta method is data."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Interpolant(NamedTuple):
    """Dense output in the form of DOP853: stages beyond the step's end, and weights of a polynomial in its powers.

    It is a Hermite cubic of the step's ends and slopes, and a bump for each row of d, which weighs all slopes.
    """

    a: np.ndarray  # (e, s + 1 + e) of the extra stages
    c: np.ndarray  # (e,)
    d: np.ndarray  # (m, s + 1 + e)


NO_INTERPOLANT = Interpolant(np.zeros((0, 0)), np.zeros(0), np.zeros((0, 0)))


class Tableau(NamedTuple):
    """Butcher coefficients; error rows weigh the stages and, last, the slope at the new point."""

    a: np.ndarray  # (s, s)
    b: np.ndarray  # (s,)
    c: np.ndarray  # (s,)
    error: np.ndarray  # (s + 1,) main error weights; empty for fixed-step methods
    error_low: np.ndarray  # (s + 1,) second estimate (DOP853), or empty
    order: int
    error_order: int
    dense: Interpolant = NO_INTERPOLANT


def stability_polynomial(tableau: Tableau) -> tuple[float, ...]:
    """Return the coefficients of R(z) = 1 + z b^T (I - z A)^-1 1, lowest power first."""
    power, coefficients = np.ones(len(tableau.b)), [1.0]
    for _ in range(len(tableau.b)):
        coefficients.append(float(tableau.b @ power))
        power = tableau.a @ power
    return tuple(coefficients)
