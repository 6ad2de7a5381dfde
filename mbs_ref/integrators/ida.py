"""SUNDIALS IDA, the official descendant of DASSL, on the DAE itself in a chosen index form.

Source: L. R. Petzold, A description of DASSL, 1982; A. C. Hindmarsh et al., ACM TOMS 31 (2005) 363-396.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mbs_ref.integrators.contact_events import ContactEvents, event_end
from mbs_ref.integrators.crossing import is_near_singular, leap
from mbs_ref.integrators.leg import (
    CLOCK_COMPLIANCE,
    CLOCK_T,
    COUNT_REJECTED,
    COUNT_RHS,
    COUNT_STEPS,
    FEWEST,
    MESSAGES,
    RUNNING,
    STALLED,
    Advance,
    Leg,
    Options,
    Pace,
    Progress,
)
from mbs_ref.jointed_system import JointedSystem
from mbs_ref.kernels.core import FORM
from mbs_ref.kernels.residual import GGL, largest_balance, residual
from mbs_ref.system import System
from mbs_ref.trajectory import Status

PACKAGE = "sundials4py"
PROXIMAL = 1e-12  # s, of a multiplier over the heaviest mass, left in its own row
MULTIPLIER_SHARE = 1e-4  # of the largest applied force at the start
HOPELESS_FAILURES, HOPELESS_SHARE = 500, 0.4  # error-test failures, in all and per step taken, that end a run
STOPPED = {  # IDA's return values, in words
    -1: ("too much work between outputs", Status.TOO_MANY_STEPS),
    -2: ("the asked accuracy is beyond double precision", Status.STEP_TOO_SMALL),
    -3: ("the error test failed repeatedly or with the smallest step", Status.STEP_TOO_SMALL),
    -4: ("Newton's iteration failed repeatedly or with the smallest step", Status.NOT_CONVERGED),
    -6: ("the iteration matrix is singular (set-up failed)", Status.NOT_CONVERGED),
    -7: ("the linear solve failed", Status.NOT_CONVERGED),
    -8: ("the residual is not finite", Status.NON_FINITE),
    -10: ("the residual is not finite, repeatedly", Status.NON_FINITE),
    -22: ("an input is illegal", Status.ENGINE_ERROR),
}


class _Ida:
    """One IDA memory with everything it refers to kept alive."""

    def __init__(
        self, system: JointedSystem, options: Options, form: int, y: np.ndarray, t0: float, events: ContactEvents,
        longest: float,
    ) -> None:  # fmt: skip
        from sundials4py import core, idas

        self.core, self.idas = core, idas
        self.system, self.form, self.events, self.size = system, form, events, len(y)
        self.kept = system.independent_rows(t0, y)
        rows = np.array([(slot, row) for _, slot, row in system.rows()], dtype=np.int64).reshape(-1, 2)[self.kept]
        self.row_slot, self.row_row = np.ascontiguousarray(rows[:, 0]), np.ascontiguousarray(rows[:, 1])
        self.lam = np.zeros_like(system.scratch.rows.multiplier)
        self.balance = np.zeros(len(y) - system.n_positions)
        self.residuals, self.heaviest = 0, float(system.groups.bodies.mass.max())
        size = len(y) + len(rows) * (2 if form == GGL else 1)
        _, self.context = core.SUNContext_Create(core.SUN_COMM_NULL)
        core.SUNContext_ClearErrHandlers(self.context)  # failures are reported by flag, not on stderr
        self.yy, self.yp, self.ids = (core.N_VNew_Serial(size, self.context) for _ in range(3))
        self._start(y, t0, len(rows))
        self.view = idas.IDACreate(self.context)
        self.memory = self.view.get()
        self._ok(idas.IDAInit(self.memory, self._residual, t0, self.yy, self.yp), "IDAInit")
        self.atol = core.N_VNew_Serial(size, self.context)
        core.N_VGetArrayPointer(self.atol)[:] = options.atol
        core.N_VGetArrayPointer(self.atol)[len(y) :] = self._multiplier_tolerance(options, y, t0)
        self._ok(idas.IDASVtolerances(self.memory, options.rtol, self.atol), "IDASVtolerances")
        self._ok(idas.IDASetId(self.memory, self.ids), "IDASetId")
        # Without this the error test includes the multipliers: 91 000 steps and a wrong answer at rtol 1e-4.
        self._ok(idas.IDASetSuppressAlg(self.memory, 1), "IDASetSuppressAlg")
        self._ok(idas.IDASetMaxNumSteps(self.memory, options.max_steps), "IDASetMaxNumSteps")
        self._ok(idas.IDASetMaxStep(self.memory, longest), "IDASetMaxStep")
        self.matrix = core.SUNDenseMatrix(size, size, self.context)
        self.solver = core.SUNLinSol_Dense(self.yy, self.matrix, self.context)
        self._ok(idas.IDASetLinearSolver(self.memory, self.solver, self.matrix), "IDASetLinearSolver")
        if len(events.g):
            self._ok(idas.IDARootInit(self.memory, len(events.g), self._event_functions), "IDARootInit")
            self._ok(idas.IDASetNoInactiveRootWarn(self.memory), "IDASetNoInactiveRootWarn")

    def _start(self, y: np.ndarray, t0: float, rows: int) -> None:
        """Fill consistent x and x' and mark what is differential."""
        dy = self.system.derivative(t0, y)
        lam = self._multipliers(y, t0)
        x, xp, ids = (self.core.N_VGetArrayPointer(v) for v in (self.yy, self.yp, self.ids))
        x[:], xp[:], ids[:] = 0.0, 0.0, 0.0
        x[: len(y)], x[len(y) : len(y) + rows] = y, lam
        xp[: len(y)] = dy
        ids[: len(y)] = 1.0

    def _multipliers(self, y: np.ndarray, t0: float) -> np.ndarray:
        """Return those of the rows that are kept; they carry the dropped rows' forces."""
        every = self.system.multipliers(t0, y)
        if len(self.kept) == len(every):
            return every
        jacobian = self.system.jacobian(t0, y)
        return np.linalg.lstsq(jacobian[self.kept].T, jacobian.T @ every)[0]

    def _multiplier_tolerance(self, options: Options, y: np.ndarray, t0: float) -> float:
        """Return what Newton may leave in a multiplier (N): it enters velocities only through h lambda / m.

        Held to the states' own tolerance, lambda's roundoff of eps / h stops every small step.
        """
        force = largest_balance(self.system.model, self.system.work, t0, y, self.lam, self.balance)
        return max(options.atol, MULTIPLIER_SHARE * max(1.0, force))

    def _residual(self, t: float, yy: Any, yp: Any, rr: Any, _data: Any = None) -> int:
        point = self.core.N_VGetArrayPointer
        out = point(rr)
        residual(
            self.system.model, self.system.work, t, point(yy), point(yp), self.form, PROXIMAL,
            self.heaviest, self.row_slot, self.row_row, self.lam, self.balance, out,
        )  # fmt: skip
        self.residuals += 1
        return 0 if np.isfinite(out).all() else 1

    def _event_functions(self, t: float, yy: Any, _yp: Any, out: np.ndarray, _data: Any = None) -> int:
        self.events.gaps(t, self.core.N_VGetArrayPointer(yy)[: self.size], out)
        return 0

    def _ok(self, flag: int, call: str) -> None:
        if flag < 0:
            raise RuntimeError(f"{call} of SUNDIALS returned {flag}")

    def step(self, t_out: float) -> tuple[int, float]:
        """Take one internal step towards t_out, never past it."""
        self.idas.IDASetStopTime(self.memory, t_out)
        return self.idas.IDASolve(self.memory, t_out, self.yy, self.yp, self.idas.IDA_ONE_STEP)

    def state(self, size: int) -> np.ndarray:
        return self.core.N_VGetArrayPointer(self.yy)[:size].copy()

    def failed_error_tests(self) -> int:
        return self.idas.IDAGetNumErrTestFails(self.memory)[1]


def ida(form: int) -> Advance:
    """Return the leg-by-leg driver of one index form."""

    def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
        assert isinstance(system, JointedSystem)  # `cores` of the Integrator sees to it
        system.prepare(FORM)
        states, worst = np.empty((len(times), len(y))), np.zeros(len(times))
        states[0] = y
        t, reached, now = float(times[0]), 1, y.copy()
        longest = float(times[-1] - times[0]) / FEWEST
        events = ContactEvents(system, options, run)
        code = events.settle(t, now)
        if code != RUNNING:
            return event_end(code, t, y, now, Leg(states, worst, reached, Status.SUCCESS))
        solver = _Ida(system, options, form, now, t, events, longest)
        loops = options.project and system.n_closure_rows > 0
        pace = Pace(t, float(times[-1]), options.max_steps, every=2_000)
        status, message = Status.SUCCESS, ""
        while reached < len(times):
            flag, t_new = solver.step(float(times[reached]))
            if flag < 0:
                words, status = STOPPED.get(flag, (f"SUNDIALS stopped with flag {flag}", Status.ENGINE_ERROR))
                message = f"at t = {t:.9g} s {words} (IDA flag {flag})"
                break
            run.counts[COUNT_STEPS] += 1
            step, t = t_new - t, t_new
            now = solver.state(len(y))
            gap, _ = system.compliance(t, now)
            run.clock[CLOCK_COMPLIANCE] = max(run.clock[CLOCK_COMPLIANCE], gap)
            if options.stop_on_compliance and gap >= step:
                status, message = Status.COMPLIANCE, f"at t = {t:.9g} s |C| = {gap:.3g} is not below h = {step:.3g}"
                break
            failed = solver.failed_error_tests()
            if failed > HOPELESS_FAILURES and failed > HOPELESS_SHARE * run.counts[COUNT_STEPS]:
                status = Status.NOT_CONVERGED
                message = (
                    f"at t = {t:.9g} s the error test has failed {failed} times in {run.counts[COUNT_STEPS]} steps: "
                    "its estimate does not shrink with the step, as is known of raw index 3"
                )
                break
            if pace.is_hopeless(t, int(run.counts[COUNT_STEPS])):
                status, message = Status.STEP_TOO_SMALL, f"at t = {t:.9g} s {MESSAGES[STALLED]}"
                break
            if run.counts[COUNT_STEPS] >= options.max_steps:
                status, message = Status.TOO_MANY_STEPS, f"at t = {t:.9g} s the limit on steps was reached"
                break
            if t >= times[reached]:
                states[reached], worst[reached] = now, run.clock[CLOCK_COMPLIANCE]
                run.clock[CLOCK_COMPLIANCE] = 0.0
                reached += 1
            if flag == solver.idas.IDA_ROOT_RETURN and reached < len(times):
                run.counts[COUNT_RHS] += solver.residuals
                run.counts[COUNT_REJECTED] += solver.failed_error_tests()
                code = events.settle(t, now)
                if code != RUNNING:
                    run.clock[CLOCK_T] = t
                    return event_end(code, t, y, now, Leg(states, worst, reached, status))
                solver = _Ida(system, options, form, now, t, events, longest)
            elif loops and reached < len(times) and is_near_singular(system, t, now):
                run.counts[COUNT_RHS] += solver.residuals
                run.counts[COUNT_REJECTED] += solver.failed_error_tests()
                landing = leap(system, options, run, t, now, times, reached, states)
                t, reached = landing.t, landing.reached
                if landing.failed is not None:
                    status, message = landing.failed.status, landing.failed.message
                    break
                now = landing.y
                solver = _Ida(system, options, form, now, t, events, longest)
        run.clock[CLOCK_T] = t
        y[:] = now
        run.counts[COUNT_RHS] += solver.residuals
        run.counts[COUNT_REJECTED] += solver.failed_error_tests()
        return Leg(states, worst, reached, status, message)

    return advance
