"""DASSL (SUNDIALS IDA, its official descendant) on four forms of the DAE.

The forms beside the first show why indices are reduced. No call of a residual passes through Python: the functions of
SUNDIALS are called as C has them, by the prototypes of the manual, SUNDIALS 7 (sunrealtype is double, sunindextype
int64_t, sunbooleantype int). The Python package's extension holds the library and exports it.

Source: L. R. Petzold, A description of DASSL, 1982; A. C. Hindmarsh et al., ACM TOMS 31 (2005) 363-396.
"""

import re
from ctypes import CDLL, POINTER, byref, c_double, c_int, c_int64, c_long, c_void_p, cast
from functools import cache, partial
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np

from mbs_ref.cores.jointed_system import JointedSystem
from mbs_ref.integrators import methods
from mbs_ref.integrators.loop.leg import Advance, Integrator, Leg, Options, Progress
from mbs_ref.integrators.loop.multistep import Interpolant, MultistepLeg, beyond_remainders, joined
from mbs_ref.kernels.answers import FORM
from mbs_ref.kernels.border.groups import empty
from mbs_ref.kernels.border.handles import make_handle
from mbs_ref.kernels.residual import GGL, INDEX_1, INDEX_2, INDEX_3, Dae, DaeGroups, largest_balance, residual_for_c
from mbs_ref.trajectory import Status

if TYPE_CHECKING:
    from mbs_ref.cores.system import System

# what the prototypes in sundials.txt are written with
_TYPES: dict[str, Any] = {"int": c_int, "int64_t": c_int64, "long": c_long, "double": c_double, "void*": c_void_p}
_TYPES |= {"void": None} | {f"{name}*": POINTER(_TYPES[name]) for name in ("long", "double", "void*")}
_PROTOTYPE = re.compile(r"(\S+) (\w+)\((.*)\)")
ONE_STEP = 2  # IDA_ONE_STEP of IDASolve


@cache
def sundials(file: str) -> Any:
    """Return the library in a file, its functions typed; AttributeError names the first that it lacks."""
    library = CDLL(file)
    for returns, name, takes in _PROTOTYPE.findall((files(methods) / "sundials.txt").read_text(encoding="utf-8")):
        function = getattr(library, name)
        function.restype, function.argtypes = _TYPES[returns], [_TYPES[kind] for kind in takes.split(", ")]
    return library


NO_MPI = 0  # SUN_COMM_NULL
PROXIMAL = 1e-12  # of the scene's time, of a multiplier over the heaviest mass, remaining in its own row
MULTIPLIER_SHARE = 1e-4  # of the largest applied force at the start, or of what moves the heaviest body
HOPELESS_FAILURES, HOPELESS_SHARE = 500, 0.4  # error-test failures, in all and per step taken, that end a run
CJ_CHANGE = 0.5  # of alpha/h, (1 - r)/(1 + r) to its inverse: IDA's 0.25 makes a Jacobian at each doubling of h
NEWTON_OF_EVENTS = 0.03  # of the tolerance, that Newton may leave in a scene with events
NEWTON_OF_RATES = 0.1  # of the tolerance, that Newton may leave at plain index 2: in C_dot it adds up to drift
STOPPED = {  # IDA's return values, in words
    -1: ("too much work between outputs", Status.TOO_MANY_STEPS),
    -2: ("the requested accuracy is beyond double precision", Status.STEP_TOO_SMALL),
    -3: ("the error test failed repeatedly or with the smallest step", Status.STEP_TOO_SMALL),
    -4: ("Newton's iteration failed repeatedly or with the smallest step", Status.NOT_CONVERGED),
    -6: ("the iteration matrix is singular (set-up failed)", Status.NOT_CONVERGED),
    -7: ("the linear solve failed", Status.NOT_CONVERGED),
    -8: ("the residual is not finite", Status.NON_FINITE),
    -10: ("the residual is not finite, repeatedly", Status.NON_FINITE),
    -22: ("an input is illegal", Status.ENGINE_ERROR),
}


def as_dae(system: JointedSystem, form: int, used: np.ndarray, proximal: float) -> Dae:
    """Return a system as a DAE of these of its rows, with proximal (s) times mu added to mu's rows."""
    rows = np.array([(slot, row) for _, slot, row in system.rows()], dtype=np.int64).reshape(-1, 2)[used]
    slots, most = system.scratch.rows.multiplier.shape
    n_rates = len(system.initial_state()) - system.n_positions
    dae = empty(Dae, n_rows=len(rows), n_slots=slots, rows=most, n_rates=n_rates)
    dae.system[:] = system.model.address, system.work.address
    dae.form[0] = form
    dae.softness[:] = proximal / _heaviest(system), proximal
    dae.slot[:], dae.row[:] = rows.T
    return dae


def _heaviest(system: JointedSystem) -> float:
    return float(system.groups.bodies.mass.max())


class _Objects:
    """What SUNDIALS allocated for one memory; freed with this."""

    def __init__(self, size: int, arrays: tuple[np.ndarray, ...]) -> None:
        import sundials4py

        self.library = library = sundials(str(sundials4py.__file__))
        self.context = c_void_p()
        library.SUNContext_Create(NO_MPI, byref(self.context))
        library.SUNContext_ClearErrHandlers(self.context)  # failures are reported by flag, not on stderr
        self.vectors = [library.N_VMake_Serial(size, array.ctypes.data, self.context) for array in arrays]
        self.matrix = library.SUNDenseMatrix(size, size, self.context)
        self.solver = library.SUNLinSol_Dense(self.vectors[0], self.matrix, self.context)
        self.memory = c_void_p(library.IDACreate(self.context))

    def __del__(self) -> None:
        library = self.library
        library.IDAFree(byref(self.memory))
        library.SUNLinSolFree(self.solver)
        library.SUNMatDestroy(self.matrix)
        for vector in self.vectors:
            library.N_VDestroy(vector)
        library.SUNContext_Free(byref(self.context))


class _Ida:
    """One IDA memory that owns everything it refers to."""

    def __init__(self, leg: MultistepLeg, form: int) -> None:
        system, options, y, t0 = leg.system, leg.options, leg.now, leg.t
        assert isinstance(system, JointedSystem)  # `cores` of the Integrator sees to it
        self.system, self.n_state, self.t = system, len(y), t0
        self.used = system.independent_rows(t0, y)
        self.dae = as_dae(system, form, self.used, PROXIMAL * options.time)
        rows = len(self.used)
        size = len(y) + (2 if form == GGL else 1) * rows
        self.x, self.rate, self.differential, self.atol, self.between = (np.zeros(size) for _ in range(5))
        self.objects = _Objects(size, (self.x, self.rate, self.differential, self.atol, self.between))
        self.library, self.memory = self.objects.library, self.objects.memory
        self.dae.numbers_of[0] = cast(self.library.N_VGetArrayPointer, c_void_p).value or 0
        self.handle = make_handle(DaeGroups(self.dae))
        self._start(y, t0, rows)
        self._set_up(leg, y, t0)

    def _set_up(self, leg: MultistepLeg, y: np.ndarray, t0: float) -> None:
        options, objects = leg.options, self.objects
        x, rate, differential, atol, _ = objects.vectors
        self._call("IDAInit", residual_for_c(), t0, x, rate)
        self._call("IDASetUserData", self.handle.ctypes.data)
        self.atol[: len(y)] = options.atol
        mu = len(y) + len(self.used)
        self.atol[len(y) : mu] = self._multiplier_tolerance(options, y, t0)
        # mu moves positions by h mu: in the first step, of about rtol, it is roundoff over h
        share = max(MULTIPLIER_SHARE, 10.0 * np.finfo(float).eps / options.rtol)
        self.atol[mu:] = share * options.units[self.system.n_positions]
        self._call("IDASVtolerances", options.rtol, atol)
        self._call("IDASetId", differential)
        # Without this the error test includes the multipliers: 91 000 steps and a wrong answer at rtol 1e-4.
        self._call("IDASetSuppressAlg", 1)
        if self.dae.form[0] == INDEX_2:
            self._call("IDASetNonlinConvCoef", NEWTON_OF_RATES)
        elif leg.events.watched:
            self._call("IDASetNonlinConvCoef", NEWTON_OF_EVENTS)
        self._call("IDASetMaxNumSteps", options.max_steps)
        self._call("IDASetMaxStep", leg.longest)
        self._call("IDASetInitStep", self._first_step(leg))
        self._call("IDASetLinearSolver", objects.solver, objects.matrix)
        self._call("IDASetDeltaCjLSetup", CJ_CHANGE)

    def _start(self, y: np.ndarray, t0: float, rows: int) -> None:
        """Fill consistent x and x' and mark what is differential."""
        dy = self.system.derivative(t0, y)
        lam = self._multipliers(y, t0)
        self.x[: len(y)], self.x[len(y) : len(y) + rows] = y, lam
        self.rate[: len(y)] = dy
        self.differential[: len(y)] = 1.0

    def _multipliers(self, y: np.ndarray, t0: float) -> np.ndarray:
        """Return those of the rows in use; they carry the dropped rows' forces."""
        every = self.system.multipliers(t0, y)
        if len(self.used) == len(every):
            return every
        jacobian = self.system.jacobian(t0, y)
        return np.linalg.lstsq(jacobian[self.used].T, jacobian.T @ every)[0]

    def _multiplier_tolerance(self, options: Options, y: np.ndarray, t0: float) -> float:
        """Return what Newton may leave in a multiplier (N): it enters velocities only through h lambda / m.

        Held to the states' own tolerance, lambda's roundoff of eps / h stops every small step.
        """
        force = largest_balance(self.system.model, self.system.work, t0, y, self.dae.lam, self.dae.balance)
        heaviest = _heaviest(self.system) * float(options.units[self.system.n_positions]) / options.time  # m L / T^2
        return MULTIPLIER_SHARE * max(heaviest, force)

    def _first_step(self, leg: MultistepLeg) -> float:
        """Return LSODE's first step (s), about rtol^(1/2) over the largest relative rate.

        IDA's own of rtol/2 over that rate moves the state by no more than what Newton leaves of it.

        Source: A. C. Hindmarsh, ODEPACK, in Scientific Computing (1983) 55-64, subroutine DLSODE, block C.
        """
        n, rtol = self.n_state, leg.options.rtol
        rate = np.sqrt(np.mean((self.rate[:n] / (rtol * abs(self.x[:n]) + self.atol[:n])) ** 2))
        return 1.0 / float(np.sqrt(1.0 / (rtol * (leg.times[-1] - self.t) ** 2) + rtol * rate**2))

    def _call(self, name: str, *given: Any) -> None:
        flag = getattr(self.library, name)(self.memory, *given)
        if flag < 0:
            raise RuntimeError(f"{name} of SUNDIALS returned {flag}")

    def step(self, leg: MultistepLeg) -> int:
        """Take one internal step towards the next output, never past it; return IDA's flag, negative for a failure."""
        t_out, t, vectors = float(leg.times[leg.reached]), c_double(), self.objects.vectors
        self.begin = self.t, self.y, self.rate[: self.n_state].copy()
        self.library.IDASetStopTime(self.memory, t_out)
        flag = self.library.IDASolve(self.memory, t_out, byref(t), vectors[0], vectors[1], ONE_STEP)
        self.t = t.value
        return flag

    @property
    def y(self) -> np.ndarray:
        """The state where the last step ended."""
        return self.x[: self.n_state].copy()

    def dense_output(self) -> Interpolant:
        """Return the interpolant of the last step, joined to the step before."""
        return joined(partial(self._between, 0), partial(self._between, 1), self.begin, self.t)

    def _between(self, derivative: int, t: float) -> np.ndarray:
        self._call("IDAGetDky", t, derivative, self.objects.vectors[4])
        return self.between[: self.n_state].copy()

    def failed_error_tests(self) -> int:
        count = c_long()
        self.library.IDAGetNumErrTestFails(self.memory, byref(count))
        return count.value

    def count(self, run: Progress) -> None:
        """Add what this memory spent."""
        run.rhs_calls += int(self.dae.evaluations[0])
        run.rejected += self.failed_error_tests()


def _passes_tests(leg: MultistepLeg, solver: _Ida) -> bool:
    """Return whether the error test still distinguishes steps; where it fails whatever the step, the leg ends."""
    failed, steps = solver.failed_error_tests(), leg.run.steps
    if failed <= HOPELESS_FAILURES or failed <= HOPELESS_SHARE * steps:
        return True
    leg.stop(
        Status.NOT_CONVERGED,
        f"the error test has failed {failed} times in {steps} steps: its estimate does not shrink with the step",
    )
    return False


def ida(form: int) -> Advance:
    """Return the leg-by-leg driver of one index form."""

    @beyond_remainders
    def advance(system: "System", options: Options, run: Progress, y: np.ndarray, times: np.ndarray) -> Leg:
        assert isinstance(system, JointedSystem)  # `cores` of the Integrator sees to it
        system.prepare(FORM)
        leg = MultistepLeg(system, options, run, y, times)
        solver: _Ida | None = None
        while leg.goes_on():
            solver = solver or _Ida(leg, form)
            flag = solver.step(leg)
            if flag < 0:
                words, status = STOPPED.get(flag, (f"SUNDIALS stopped with flag {flag}", Status.ENGINE_ERROR))
                leg.stop(status, f"{words} (IDA flag {flag})")
                break
            t, now = leg.events.locate(leg.t, leg.now, solver)
            arrived = leg.arrive(t, now, solver.t - leg.t)
            if not (arrived and _passes_tests(leg, solver) and leg.keeps_pace()):
                break
            if leg.t >= times[leg.reached]:
                leg.record(leg.now)
            if leg.jumps(leg.events.at_event):
                solver.count(run)
                solver = None
        if solver is not None:
            solver.count(run)
        return leg.finish()

    return advance


_integrator = partial(
    Integrator,
    kind="adaptive",
    order=5,
    varies_order=True,
    ladder=(1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12),
    source="Petzold 1982; Hindmarsh et al. 2005; Gear, Gupta, Leimkuhler 1985",
    package="sundials4py",
    holds_deflections=False,
    cores=("planar", "spatial"),
    stabilizations=("none", "projection"),
)
dassl = _integrator(
    name="dassl",
    description="DASSL (SUNDIALS IDA) on the stabilised index-2 (GGL) form",
    advance=ida(GGL),
    needs_positions=True,
)
dassl_index1 = _integrator(
    name="dassl_index1", description="DASSL (SUNDIALS IDA) on the index-1 form: drifts", advance=ida(INDEX_1)
)
dassl_index2 = _integrator(
    name="dassl_index2",
    description="DASSL (SUNDIALS IDA) on the index-2 form, C_dot = 0: positions drift",
    advance=ida(INDEX_2),
    source="Petzold 1982; Hindmarsh et al. 2005; Brenan, Campbell, Petzold 1996, sec. 6.2",
)
dassl_index3 = _integrator(
    name="dassl_index3",
    description="DASSL (SUNDIALS IDA) on the raw index-3 form: fails or is poor, and shows why indices are reduced",
    advance=ida(INDEX_3),
    stabilization="none",
    stabilizations=("none",),
    weakness="the error test and Newton's iteration of raw index 3 do not improve with the step",
    needs_positions=True,
)
