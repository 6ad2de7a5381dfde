"""LSODAR, the papers' method: Adams and BDF with automatic switching, on the underlying ODE.

SciPy carries LSODA, which is LSODAR without its root finder. Roots are located here, as LSODAR does, on the
interpolant of the last step; events and declared breakpoints restart it. Steps of both are the same.
BDF's iteration matrix is factored by LAPACK, whose threads may sum in another order: of a system as large as the
vertebral android the last bits depend on OMP_NUM_THREADS; with as many threads they repeat.
Source: L. R. Petzold, SIAM J. Sci. Stat. Comput. 4 (1983) 136-148; A. C. Hindmarsh, ODEPACK, 1983.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import scipy

from mbs_ref.integrators.loop.leg import Integrator, Leg, Options, Progress
from mbs_ref.integrators.loop.multistep import Ending, Interpolant, MultistepLeg, beyond_remainders, joined
from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from scipy.integrate import LSODA

    from mbs_ref.cores.system import System

TIGHTEST = 100.0 * np.finfo(float).eps  # relative tolerance: SciPy takes none tighter, and warns
ADAMS = 1  # ODEPACK's number of the family that every start begins with; 2 is BDF


@beyond_remainders
def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
    """Integrate one leg; outputs come from the method's own interpolant."""
    leg = MultistepLeg(system, options, run, y, times)
    solver: LSODA | None = None
    family = ADAMS
    while leg.goes_on():
        if solver is None:
            solver, family = _start(leg), ADAMS
        before, then, failure = solver.t, np.array(solver.y), solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            leg.ending = _failure(solver, failure)
            break
        before_it, family = family, _family(solver)
        run.switches += family != before_it
        t, now = leg.events.locate(before, then, solver, _slope(solver))
        # the method's own step, where an event cuts it
        if not (leg.arrive(t, now, solver.t - before) and leg.keeps_pace()):
            break
        _record_passed(solver, leg)
        if leg.jumps(leg.events.at_event):
            run.rhs_calls += solver.nfev
            solver = None
    run.rhs_calls += solver.nfev if solver is not None else 0
    return leg.finish()


def _record_passed(solver: LSODA, leg: MultistepLeg) -> None:
    """Store every output time that the last step passed, up to where it ends or an event cuts it."""
    interpolant = None
    while leg.goes_on() and leg.times[leg.reached] <= leg.t:
        asked = leg.times[leg.reached]
        interpolant = interpolant or solver.dense_output()
        leg.record(solver.y if asked == solver.t else interpolant(asked))


def _start(leg: MultistepLeg) -> LSODA:
    """Return a solver from where the leg is to its end, where a pulse is zero: its ends must not make a step."""
    return _joined()(leg.system, leg.options, leg.t, leg.now, float(leg.times[-1]), leg.longest)


@cache
def _joined() -> type:
    """Return LSODA as used here, a class built when first used: importing SciPy's integrators takes long."""

    class Joined(scipy.integrate.LSODA):
        """Integrates z' = f(P(z)) and gives y = P(z) at steps and between them; P is a projection, or changes nothing.

        f is smooth through singular poses on the constraints alone; z, which carries LSODA's history, may drift off
        them by the tolerance, y may not.
        """

        def __init__(
            self, system: System, options: Options, t: float, y: np.ndarray, t_end: float, longest: float
        ) -> None:
            self.system, self.tolerance = system, options.projection_tolerance if options.project else None
            f = self._derivative if options.project else system.derivative
            rtol = max(options.rtol, TIGHTEST)
            super().__init__(f, t, y, t_end, max_step=longest, rtol=rtol, atol=options.atol)

        def _derivative(self, t: float, z: np.ndarray) -> np.ndarray:
            return self.system.derivative(t, self._onto(t, z))

        def _onto(self, t: float, z: np.ndarray) -> np.ndarray:
            if self.tolerance is None:
                return z
            y = np.array(z)
            self.system.project(t, y, self.tolerance)
            return y

        def _step_impl(self) -> tuple[bool, str | None]:
            self.begin = self.t, np.array(self.y), None if self.t_old is None else np.array(_slope(self))
            ended = super()._step_impl()
            if ended[0] and np.isfinite(self.y).all():
                self.y = self._onto(self.t, self.y)
            return ended

        def dense_output(self) -> Interpolant:
            """Return the interpolant of the last step: Nordsieck's polynomial, joined to the step before."""
            steps, (t0, y0, slope) = super().dense_output(), self.begin
            slope = self.fun(t0, y0) if slope is None else slope

            def rate(t: float) -> np.ndarray:
                powers = steps.p * ((t - steps.t) / steps.h) ** np.maximum(steps.p - 1, 0)
                return steps.yh @ powers / steps.h

            between = joined(steps, rate, (t0, y0, slope), self.t)
            return lambda t: self._onto(t, between(t))

    return Joined


def _family(solver: LSODA) -> int:
    """Return ADAMS or BDF, which took the last step: MUSED of ODEPACK, which SciPy keeps to itself."""
    return int(solver._lsoda_solver._integrator.iwork[18])  # pyright: ignore[reportAttributeAccessIssue]


def _slope(solver: LSODA) -> np.ndarray:
    """Return dy/dt (n,) at the end of the last step: that of the corrector's last iterate, in the Nordsieck array."""
    work = solver._lsoda_solver._integrator.rwork  # pyright: ignore[reportAttributeAccessIssue]
    return work[20 + solver.n : 20 + 2 * solver.n] / work[11]


def _failure(solver: LSODA, words: str | None) -> Ending:
    if not np.isfinite(solver.y).all():
        return Ending(Status.NON_FINITE, f"at t = {solver.t:.9g} s a state became infinite or NaN")
    return Ending(Status.STEP_TOO_SMALL, f"at t = {solver.t:.9g} s LSODA gave up: {words or 'no reason given'}")


METHOD = Integrator(
    name="lsodar",
    kind="adaptive",
    order=12,
    varies_order=True,
    description="Adams (order up to 12) and BDF (up to 5) with automatic switching: the papers' LSODAR, through SciPy",
    advance=advance,
    switches="Adams and BDF",
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    source="Petzold 1983; Hindmarsh 1983",
)
