"""SciPy's Radau IIA in double precision, for stiff motions, stepped exactly onto the asked times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cross_checks.certify.numerics.runge_kutta import step_through

TOLERANCE = 1e-12  # its steps are of order 5: tighter ones cost minutes


def radau(derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Integrate y' = derivative(t, y) from times[0]; return y at `times`, shape (n_t, n). Raises NoConvergenceError."""
    from scipy.integrate import Radau  # its import takes a third of a second: only who makes a truth pays

    return step_through(Radau, derivative, start, times, max(tolerance, TOLERANCE))
