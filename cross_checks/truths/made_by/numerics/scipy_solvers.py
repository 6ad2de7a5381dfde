"""SciPy's DOP853, LSODA and Radau IIA in double precision, stepped exactly onto the requested times."""

from collections.abc import Callable
from typing import Any

import numpy as np

from cross_checks.truths.truth import NoConvergenceError, check_time


def runge_kutta(derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Integrate y' = derivative(t, y) from times[0]; return y at `times`, shape (n_t, n). Raises NoConvergenceError."""
    from scipy.integrate import DOP853  # its import takes a third of a second: only who makes a truth pays

    return step_through(DOP853, derivative, start, times, tolerance)


def step_through(solver_type: Any, derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float):
    """Step a SciPy solver onto every time: its dense output is of lower order."""
    states = np.empty((len(times), len(start)))
    states[0] = start
    step = None
    for k in range(1, len(times)):
        first = None if step is None else min(step, times[k] - times[k - 1])
        solver = solver_type(
            derivative, times[k - 1], states[k - 1], times[k], rtol=tolerance, atol=tolerance, first_step=first
        )
        while solver.status == "running":
            check_time(solver.t)
            message = solver.step()
            if solver.status == "failed":
                raise NoConvergenceError(f"{solver_type.__name__} stops at t = {solver.t:.6g} s: {message}")
        states[k], step = solver.y, getattr(solver, "h_abs", None)  # LSODA keeps its own
    return states


def lsoda(derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Integrate a stiff y' = derivative(t, y) as `runge_kutta` does, by backward differentiation formulas."""
    from scipy.integrate import LSODA

    return step_through(LSODA, derivative, start, times, tolerance)


RADAU_TOLERANCE = 1e-12  # its steps are of order 5: tighter ones cost minutes


def radau(derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Integrate a stiff y' = derivative(t, y) as `runge_kutta` does, by collocation."""
    from scipy.integrate import Radau

    return step_through(Radau, derivative, start, times, max(tolerance, RADAU_TOLERANCE))
