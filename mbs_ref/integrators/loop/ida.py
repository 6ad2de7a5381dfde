"""SUNDIALS IDA, the official descendant of DASSL, on the DAE itself in a chosen index form.

Source: L. R. Petzold, A description of DASSL, 1982; A. C. Hindmarsh et al., ACM TOMS 31 (2005) 363-396.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.integrators.loop.leg import Advance, Leg, Options, Progress
from mbs_ref.integrators.loop.multistep import MultistepLeg
from mbs_ref.kernels.answers import FORM
from mbs_ref.kernels.residual import GGL, largest_balance, residual
from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

PACKAGE = "sundials4py"
PROXIMAL = 1e-12  # of the scene's time, of a multiplier over the heaviest mass, left in its own row
MULTIPLIER_SHARE = 1e-4  # of the largest applied force at the start, or of what moves the heaviest body
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

    def __init__(self, leg: MultistepLeg, form: int) -> None:
        from sundials4py import core, idas

        system, options, events, y, t0 = leg.system, leg.options, leg.events, leg.now, leg.t
        assert isinstance(system, JointedSystem)  # `cores` of the Integrator sees to it
        self.core, self.idas = core, idas
        self.system, self.form, self.events, self.size, self.t = system, form, events, len(y), t0
        self.kept = system.independent_rows(t0, y)
        rows = np.array([(slot, row) for _, slot, row in system.rows()], dtype=np.int64).reshape(-1, 2)[self.kept]
        self.row_slot, self.row_row = np.ascontiguousarray(rows[:, 0]), np.ascontiguousarray(rows[:, 1])
        self.lam = np.zeros_like(system.scratch.rows.multiplier)
        self.balance = np.zeros(len(y) - system.n_positions)
        self.residuals, self.heaviest = 0, float(system.groups.bodies.mass.max())
        self.proximal = PROXIMAL * options.time  # s
        size = len(y) + len(rows) * (2 if form == GGL else 1)
        _, self.context = core.SUNContext_Create(core.SUN_COMM_NULL)
        core.SUNContext_ClearErrHandlers(self.context)  # failures are reported by flag, not on stderr
        self.yy, self.yp, self.ids = (core.N_VNew_Serial(size, self.context) for _ in range(3))
        self._start(y, t0, len(rows))
        self.view = idas.IDACreate(self.context)
        self.memory = self.view.get()
        self._ok(idas.IDAInit(self.memory, self._residual, t0, self.yy, self.yp), "IDAInit")
        self.atol = core.N_VNew_Serial(size, self.context)
        core.N_VGetArrayPointer(self.atol)[: len(y)] = options.atol
        core.N_VGetArrayPointer(self.atol)[len(y) :] = self._multiplier_tolerance(options, y, t0)
        self._ok(idas.IDASVtolerances(self.memory, options.rtol, self.atol), "IDASVtolerances")
        self._ok(idas.IDASetId(self.memory, self.ids), "IDASetId")
        # Without this the error test includes the multipliers: 91 000 steps and a wrong answer at rtol 1e-4.
        self._ok(idas.IDASetSuppressAlg(self.memory, 1), "IDASetSuppressAlg")
        self._ok(idas.IDASetMaxNumSteps(self.memory, options.max_steps), "IDASetMaxNumSteps")
        self._ok(idas.IDASetMaxStep(self.memory, leg.longest), "IDASetMaxStep")
        self.matrix = core.SUNDenseMatrix(size, size, self.context)
        self.solver = core.SUNLinSol_Dense(self.yy, self.matrix, self.context)
        self._ok(idas.IDASetLinearSolver(self.memory, self.solver, self.matrix), "IDASetLinearSolver")
        if events.count:
            self._ok(idas.IDARootInit(self.memory, events.count, self._event_functions), "IDARootInit")
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
        heaviest = self.heaviest * float(options.units[self.system.n_positions]) / options.time  # m L / T^2
        return MULTIPLIER_SHARE * max(heaviest, force)

    def _residual(self, t: float, yy: Any, yp: Any, rr: Any, _data: Any = None) -> int:
        point = self.core.N_VGetArrayPointer
        out = point(rr)
        residual(
            self.system.model, self.system.work, t, point(yy), point(yp), self.form, self.proximal,
            self.heaviest, self.row_slot, self.row_row, self.lam, self.balance, out,
        )  # fmt: skip
        self.residuals += 1
        return 0 if np.isfinite(out).all() else 1

    def _event_functions(self, t: float, yy: Any, _yp: Any, out: np.ndarray, _data: Any = None) -> int:
        self.events.values(t, self.core.N_VGetArrayPointer(yy)[: self.size], out)
        return 0

    def _ok(self, flag: int, call: str) -> None:
        if flag < 0:
            raise RuntimeError(f"{call} of SUNDIALS returned {flag}")

    def step(self, leg: MultistepLeg) -> int:
        """Take one internal step towards the next output, never past it; return IDA's flag, negative for a failure."""
        t_out = float(leg.times[leg.reached])
        self.idas.IDASetStopTime(self.memory, t_out)
        flag, self.t = self.idas.IDASolve(self.memory, t_out, self.yy, self.yp, self.idas.IDA_ONE_STEP)
        return flag

    def state(self) -> np.ndarray:
        return self.core.N_VGetArrayPointer(self.yy)[: self.size].copy()

    def failed_error_tests(self) -> int:
        return self.idas.IDAGetNumErrTestFails(self.memory)[1]

    def count(self, run: Progress) -> None:
        """Add what this memory spent."""
        run.rhs_calls += self.residuals
        run.rejected += self.failed_error_tests()


def _stop_failed(leg: MultistepLeg, flag: int) -> None:
    """End the leg with IDA's reason."""
    words, status = STOPPED.get(flag, (f"SUNDIALS stopped with flag {flag}", Status.ENGINE_ERROR))
    leg.stop(status, f"{words} (IDA flag {flag})")


def _passes_tests(leg: MultistepLeg, solver: _Ida) -> bool:
    """Return whether the error test still tells steps apart; where it fails whatever the step, the leg ends."""
    failed, steps = solver.failed_error_tests(), leg.run.steps
    if failed <= HOPELESS_FAILURES or failed <= HOPELESS_SHARE * steps:
        return True
    leg.stop(
        Status.NOT_CONVERGED,
        f"the error test has failed {failed} times in {steps} steps: "
        "its estimate does not shrink with the step, as is known of raw index 3",
    )
    return False


def ida(form: int) -> Advance:
    """Return the leg-by-leg driver of one index form."""

    def advance(system: System, options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
        assert isinstance(system, JointedSystem)  # `cores` of the Integrator sees to it
        system.prepare(FORM)
        leg = MultistepLeg(system, options, run, y, times)
        solver: _Ida | None = None
        while leg.goes_on():
            solver = solver or _Ida(leg, form)
            flag = solver.step(leg)
            if flag < 0:
                _stop_failed(leg, flag)
                break
            arrived = leg.arrive(solver.t, solver.state(), solver.t - leg.t)
            if not (arrived and _passes_tests(leg, solver) and leg.keeps_pace()):
                break
            if leg.t >= times[leg.reached]:
                leg.record(leg.now)
            if leg.jumps(event=flag == solver.idas.IDA_ROOT_RETURN):
                solver.count(run)
                solver = None
        if solver is not None:
            solver.count(run)
        return leg.finish()

    return advance
