"""LSODAR, the papers' method: Adams and BDF with automatic switching, on the underlying ODE.

SciPy carries LSODA, which is LSODAR without its root finder. Roots are found here, as LSODAR does, on the
interpolant of the last step; events and declared breakpoints restart it. Steps of both are the same.
Source: L. R. Petzold, SIAM J. Sci. Stat. Comput. 4 (1983) 136-148; A. C. Hindmarsh, ODEPACK, 1983.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import LSODA

from mbs_ref.integrators.contact_events import ContactEvents, event_end
from mbs_ref.integrators.crossing import is_near_singular, leap
from mbs_ref.integrators.leg import (
    CLOCK_COMPLIANCE,
    CLOCK_T,
    COUNT_OWN,
    COUNT_RHS,
    COUNT_STEPS,
    MESSAGES,
    RUNNING,
    STALLED,
    Integrator,
    Leg,
    Options,
    Pace,
    Progress,
)
from mbs_ref.system import System
from mbs_ref.trajectory import Status

ADAMS = 1  # ODEPACK's number of the family that every start begins with; 2 is BDF


def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
    """Integrate one leg; outputs come from the method's own interpolant."""
    states, worst = np.empty((len(times), len(y))), np.zeros(len(times))
    states[0] = y
    loops = options.project and system.n_closure_rows > 0
    events = ContactEvents(system, options, run)
    solver: LSODA | None = None
    now = y.copy()
    t, reached, status, message = float(times[0]), 1, Status.SUCCESS, ""
    code = events.settle(t, now)
    if code != RUNNING:
        return event_end(code, t, y, now, Leg(states, worst, reached, status))
    pace, family = Pace(t, float(times[-1]), options.max_steps, every=2_000), ADAMS
    while reached < len(times):
        if solver is None:
            solver, family = _start(system, options, t, now, float(times[-1])), ADAMS
        before = solver.t
        failure = solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            status, message = _failure(solver, failure)
            break
        run.counts[COUNT_STEPS] += 1
        before_it, family = family, _family(solver)
        run.counts[COUNT_OWN] += family != before_it
        t, now = events.locate(before, solver)
        gap, _ = system.compliance(t, now)
        run.clock[CLOCK_COMPLIANCE] = max(run.clock[CLOCK_COMPLIANCE], gap)
        if options.stop_on_compliance and gap >= solver.t - before:  # the method's own step, where an event cuts it
            status = Status.COMPLIANCE
            message = f"at t = {t:.9g} s |C| = {gap:.3g} is not below h = {solver.t - before:.3g}"
            break
        if pace.is_hopeless(t, int(run.counts[COUNT_STEPS])):
            status, message = Status.STEP_TOO_SMALL, f"at t = {t:.9g} s {MESSAGES[STALLED]}"
            break
        if run.counts[COUNT_STEPS] >= options.max_steps:
            status, message = Status.TOO_MANY_STEPS, f"at t = {t:.9g} s the limit on steps was reached"
            break
        reached = _output(solver, t, times, reached, states, worst, run)
        if events.found and reached < len(times):
            run.counts[COUNT_RHS] += solver.nfev
            solver = None
            code = events.settle(t, now)
            if code != RUNNING:
                run.clock[CLOCK_T] = t
                return event_end(code, t, y, now, Leg(states, worst, reached, status))
        elif loops and reached < len(times) and is_near_singular(system, t, now):
            run.counts[COUNT_RHS] += solver.nfev
            solver = None
            landing = leap(system, options, run, t, now, times, reached, states)
            t, now, reached = landing.t, landing.y, landing.reached
            if landing.failed is not None:
                status, message = landing.failed.status, landing.failed.message
                break
    run.clock[CLOCK_T] = t
    y[:] = now
    run.counts[COUNT_RHS] += solver.nfev if solver is not None else 0
    return Leg(states, worst, reached, status, message)


def _output(
    solver: LSODA, t: float, times: np.ndarray, reached: int, states: np.ndarray, worst: np.ndarray, run: Progress
) -> int:
    """Fill every asked time that the last step passed, up to t."""
    interpolant = None
    while reached < len(times) and times[reached] <= t:
        interpolant = interpolant or solver.dense_output()
        states[reached] = solver.y if times[reached] == solver.t else interpolant(times[reached])
        worst[reached] = run.clock[CLOCK_COMPLIANCE]
        run.clock[CLOCK_COMPLIANCE] = 0.0
        reached += 1
    return reached


def _start(system: System, options: Options, t: float, y: np.ndarray, t_end: float) -> LSODA:
    if options.project:
        return _OnConstraints(system, options, t, y, t_end)
    return LSODA(system.derivative, t, y, t_end, rtol=options.rtol, atol=options.atol)


class _OnConstraints(LSODA):
    """Integrates z' = f(P(z)), P the projection, and gives y = P(z) at steps and between them.

    f is smooth through singular poses on the constraints alone; z, which carries LSODA's history, may drift off
    them by the tolerance, y may not.
    """

    def __init__(self, system: System, options: Options, t: float, y: np.ndarray, t_end: float) -> None:
        self.system, self.tolerance = system, options.projection_tolerance
        super().__init__(self._derivative, t, y, t_end, rtol=options.rtol, atol=options.atol)

    def _derivative(self, t: float, z: np.ndarray) -> np.ndarray:
        return self.system.derivative(t, self._onto(t, z))

    def _onto(self, t: float, z: np.ndarray) -> np.ndarray:
        y = np.array(z)
        self.system.project(t, y, self.tolerance)
        return y

    def _step_impl(self) -> tuple[bool, str | None]:
        ended = super()._step_impl()
        if ended[0] and np.isfinite(self.y).all():
            self.y = self._onto(self.t, self.y)
        return ended

    def dense_output(self):
        between = super().dense_output()
        return lambda t: self._onto(t, between(t))


def _family(solver: LSODA) -> int:
    """Return ADAMS or BDF, by which the last step was made: MUSED of ODEPACK, which SciPy keeps to itself."""
    return int(solver._lsoda_solver._integrator.iwork[18])  # pyright: ignore[reportAttributeAccessIssue]


def _failure(solver: LSODA, words: str | None) -> tuple[Status, str]:
    if not np.isfinite(solver.y).all():
        return Status.NON_FINITE, f"at t = {solver.t:.9g} s a state became infinite or NaN"
    return Status.STEP_TOO_SMALL, f"at t = {solver.t:.9g} s LSODA gave up: {words or 'no reason given'}"


INTEGRATOR = Integrator(
    name="lsodar",
    kind="adaptive",
    order=12,
    description="Adams (order up to 12) and BDF (up to 5) with automatic switching: the papers' LSODAR, through SciPy",
    advance=advance,
    stabilizations=("none", "baumgarte", "projection"),
    switches="Adams and BDF",
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    source="Petzold 1983; Hindmarsh 1983",
)
