"""Butcher tableaux: an explicit Runge-Kutta method is data.

The coefficients of DOP853 are those of Dormand and Prince as Hairer's code has them (Hairer, Norsett, Wanner, Solving
Ordinary Differential Equations I, 2nd ed., Springer 1993, sec. II.6 and II.10). They are stored, because importing
SciPy's integrators takes longer than a short run.
"""

import json
from pathlib import Path
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
    """Butcher coefficients; error rows weigh the stages alone, so that a rejected step needs no slope at its end."""

    a: np.ndarray  # (s, s)
    b: np.ndarray  # (s,)
    c: np.ndarray  # (s,)
    error: np.ndarray  # (s,) main error weights; empty for fixed-step methods
    error_low: np.ndarray  # (s,) second estimate (DOP853), or empty
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


EULER = Tableau(np.zeros((1, 1)), np.ones(1), np.zeros(1), np.zeros(0), np.zeros(0), 1, 0)
RK4 = Tableau(  # Kutta 1901; the papers' fixed-step method
    a=np.array([[0, 0, 0, 0], [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1.0, 0]]),
    b=np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
    c=np.array([0, 0.5, 0.5, 1.0]),
    error=np.zeros(0),
    error_low=np.zeros(0),
    order=4,
    error_order=0,
)
_STORED = {
    name: np.array(values) for name, values in json.loads(Path(__file__).with_name("dop853.json").read_text()).items()
}
DOP853 = Tableau(
    *(_STORED[name] for name in ("a", "b", "c", "error", "error_low")),
    order=8,
    error_order=7,
    dense=Interpolant(*(_STORED[name] for name in ("dense_a", "dense_c", "dense_d"))),
)
