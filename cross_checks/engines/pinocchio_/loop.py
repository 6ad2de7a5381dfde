"""Runge-Kutta methods of order 4 and 8 around a right-hand side."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.integrate import DOP853

from cross_checks.engines.pinocchio_.dynamics import RightHandSide
from cross_checks.workshop.outcome import End, Plan, end_of
from mbs_ref.trajectory import Status


def _rk4_step(rhs: RightHandSide, t: float, y: np.ndarray, h: float) -> np.ndarray:
    # the right-hand side returns one array, overwritten at each call: each stage is used before the next
    k = rhs(t, y)
    total = y + (h / 6.0) * k
    k = rhs(t + 0.5 * h, y + (0.5 * h) * k)
    total += (h / 3.0) * k
    k = rhs(t + 0.5 * h, y + (0.5 * h) * k)
    total += (h / 3.0) * k
    k = rhs(t + h, y + h * k)
    total += (h / 6.0) * k
    return total


def advance_fixed(rhs: RightHandSide, y: np.ndarray, plan: Plan, max_steps: int, breakpoints: list[float]):
    states = np.zeros((len(plan.times), len(y)))
    states[0] = y
    n = 0
    for k, count in enumerate(plan.counts, start=1):
        for _ in range(count):
            y = _rk4_step(rhs, n * plan.step, y, plan.step)
            n += 1
        states[k] = y
        if not np.isfinite(y).all():
            break
    end = end_of(states[: k + 1], plan.times, End(k + 1))
    return states, end, n, 4 * n


def advance_adaptive(rhs: RightHandSide, y: np.ndarray, plan: Plan, max_steps: int, breakpoints: list[float]):
    """Stop the integrator at every output time and breakpoint: nothing is interpolated."""
    states = np.zeros((len(plan.times), len(y)))
    states[0] = y
    steps, calls, h = 0, 0, None
    stops = np.union1d(plan.times, [t for t in breakpoints if 0.0 < t < plan.times[-1]])
    reached = 1
    for begin, stop in pairwise(stops):
        first = None if h is None else min(h, stop - begin)
        solver = DOP853(lambda t, x: rhs(t, x).copy(), begin, y, stop, rtol=plan.rtol, atol=plan.atol, first_step=first)
        while solver.status == "running" and steps < max_steps:
            message = solver.step()
            steps += 1
            # the last step of an interval is cut short; the one before it tells the natural size
            h = max(h or 0.0, solver.step_size or 0.0) if solver.t == stop else solver.step_size
        calls += solver.nfev
        y = solver.y
        if solver.status != "finished":
            return states, _failure(solver, message, reached, max_steps), steps, calls
        if stop == plan.times[reached]:
            states[reached], reached = y, reached + 1
    return states, end_of(states, plan.times, End(len(plan.times))), steps, calls


def _failure(solver: DOP853, message: str | None, reached: int, max_steps: int) -> End:
    if solver.status == "running":
        return End(reached, Status.TOO_MANY_STEPS, f"max_steps = {max_steps} were used up at t = {solver.t:g} s")
    return End(reached, Status.STEP_TOO_SMALL, f"DOP853 stopped at t = {solver.t:g} s: {message}")
