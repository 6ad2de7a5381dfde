"""SciPy's solvers in double precision, stepped exactly onto the requested times."""

from collections.abc import Callable
from functools import partial

import numpy as np

from cross_checks.truths.truth import NoConvergenceError, check_time

TIGHTEST = {"Radau": 1e-12}  # its steps are of order 5: tighter ones cost minutes


def _integrate(name: str, derivative: Callable, start: np.ndarray, times: np.ndarray, tolerance: float) -> np.ndarray:
    """Integrate y' = derivative(t, y) from times[0]; return y at `times`, shape (n_t, n). Raises NoConvergenceError.

    The solver of that name is stepped onto every time: its dense output is of lower order.
    """
    from scipy import integrate  # its import takes a third of a second: only who makes a truth pays

    states, step = np.empty((len(times), len(start))), None
    states[0], tolerance = start, max(tolerance, TIGHTEST.get(name, 0.0))
    for k in range(1, len(times)):
        first = None if step is None else min(step, times[k] - times[k - 1])
        solver = getattr(integrate, name)(
            derivative, times[k - 1], states[k - 1], times[k], rtol=tolerance, atol=tolerance, first_step=first
        )
        while solver.status == "running":
            check_time(solver.t)
            message = solver.step()
            if solver.status == "failed":
                raise NoConvergenceError(f"{name} stops at t = {solver.t:.6g} s: {message}")
        states[k], step = solver.y, getattr(solver, "h_abs", None)  # LSODA hides its own
    return states


runge_kutta = partial(_integrate, "DOP853")
lsoda, radau = partial(_integrate, "LSODA"), partial(_integrate, "Radau")  # for stiff motions
