"""Pinocchio as its users drive it: a loop in C++ over its own headers, for trees that gravity alone moves."""

import ctypes
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin
from scipy.integrate import DOP853

from cross_checks.engine import RTOLS, STEPS, End, Loop, Method, Plan, Refusal, exponential
from cross_checks.engines.pinocchio_ import GAINS, PROXIMAL, Built, Pinocchio
from cross_checks.engines.pinocchio_.build import joints_of
from cross_checks.engines.pinocchio_cpp_.compiler import described, library, obstacle
from mbs_ref import Scene, Status
from mbs_ref.scene.traits import traits

KINDS = (  # in the order of the program's enumeration
    "JointModelRZ", "JointModelRevoluteUnaligned", "JointModelPrismaticUnaligned", "JointModelSpherical",
    "JointModelTranslation", "JointModelFreeFlyer",
)  # fmt: skip
FORMS = ("local", "world", "constrained", "loop_aba")  # likewise
SUCCESS, STEP_TOO_SMALL, TOO_MANY_STEPS = range(3)
TABLEAU = tuple(np.ascontiguousarray(part, dtype=float) for part in (DOP853.A, DOP853.B, DOP853.E3, DOP853.E5))
_array = np.ctypeslib.ndpointer
_REALS, _WHOLE = _array(np.float64, flags="C"), _array(np.int32, flags="C")


class Report(ctypes.Structure):
    """What a loop of the program reports."""

    _fields_ = [
        ("seconds", ctypes.c_double), ("steps", ctypes.c_long), ("calls", ctypes.c_long),
        ("rejected", ctypes.c_long), ("reached", ctypes.c_int), ("outcome", ctypes.c_int), ("t", ctypes.c_double),
    ]  # fmt: skip


class Tree:
    """A tree of joints in the program, the contacts that close its loops, and its state there."""

    def __init__(self, model: Any, every: bool = False, form: str = "local", contacts: Sequence[Any] = ()) -> None:
        parents, _, kinds, *columns = zip(*joints_of(model), strict=True)
        numbers = np.array([_numbers(*row) for row in zip(*columns, strict=True)])
        self._program = _program(every)
        self._tree = self._program.make_tree(
            FORMS.index(form),
            len(kinds),
            np.array(list(map(KINDS.index, kinds)), dtype=np.int32),
            np.array(parents, dtype=np.int32),
            numbers,
            np.array(model.gravity.linear),
        )
        if contacts:
            rows = [6 if one.type == pin.ContactType.CONTACT_6D else 3 for one in contacts]
            ends = [(one.joint1_id, one.joint2_id) for one in contacts]
            places = [np.concatenate((_place(one.joint1_placement), _place(one.joint2_placement))) for one in contacts]
            settings = np.array([*GAINS, *PROXIMAL.values()])
            whole = np.array(rows, dtype=np.int32), np.array(ends, dtype=np.int32)
            self._program.close_loops(self._tree, len(contacts), *whole, np.array(places), settings)
        weakref.finalize(self, self._program.free_tree, self._tree)

    def derivative(self, y: np.ndarray) -> np.ndarray:
        """Return (q', v') of y = (q, v)."""
        rate = np.empty_like(y)
        self._program.derivative(self._tree, y, rate)
        return rate

    def advance(self, start: np.ndarray, plan: Plan) -> Loop:
        """Return the states at the plan's times."""
        states = np.zeros((len(plan.times), len(start)))
        states[0] = start
        if plan.method.kind == "fixed":
            counts = np.array(plan.counts, dtype=np.int32)
            report = self._program.run_rk4(self._tree, states, len(states), counts, plan.step)
        else:
            limits = plan.rtol, plan.atol, plan.max_steps
            report = self._program.run_dop853(self._tree, states, len(states), plan.times, *limits, *TABLEAU)
        return Loop(states, _end(report, plan), report.steps, report.calls, report.rejected)


def _place(placement: Any) -> np.ndarray:
    return np.concatenate((placement.rotation.ravel(), placement.translation))


def _numbers(axis: np.ndarray, *others: Any) -> np.ndarray:
    """Return turn, place, axis, mass, centre and inertia of a joint's body: (28,); no axis is zeros."""
    turn, place, *body = others
    parts = turn, place, axis if len(axis) else np.zeros(3), *body
    return np.concatenate([np.asarray(part, dtype=float).ravel() for part in parts])


def _end(report: Report, plan: Plan) -> End:
    if report.outcome == TOO_MANY_STEPS:
        message = f"max_steps = {plan.max_steps} were used up at t = {report.t:g} s"
        return End(report.reached, Status.TOO_MANY_STEPS, message)
    if report.outcome == STEP_TOO_SMALL:
        message = f"DOP853 stopped at t = {report.t:g} s: its step became too small"
        return End(report.reached, Status.STEP_TOO_SMALL, message)
    return End(report.reached)


@cache
def _program(every: bool) -> ctypes.CDLL:
    program = ctypes.CDLL(str(library(every)))
    number, whole, tree = ctypes.c_double, ctypes.c_int, ctypes.c_void_p
    program.make_tree.argtypes, program.make_tree.restype = [whole, whole, _WHOLE, _WHOLE, _REALS, _REALS], tree
    if every:
        program.close_loops.argtypes = [tree, whole, _WHOLE, _WHOLE, _REALS, _REALS]
        program.close_loops.restype = None
    program.free_tree.argtypes, program.free_tree.restype = [tree], None
    program.derivative.argtypes, program.derivative.restype = [tree, _REALS, _REALS], None
    program.run_rk4.argtypes, program.run_rk4.restype = [tree, _REALS, whole, _WHOLE, number], Report
    adaptive = [tree, _REALS, whole, _REALS, number, number, ctypes.c_long, *[_REALS] * 4]
    program.run_dop853.argtypes, program.run_dop853.restype = adaptive, Report
    return program


METHODS = (
    Method("dop853", "adaptive", 8, "DOP853 in C++ with the step control of SciPy's", RTOLS, embedded=7),
    Method("rk4", "fixed", 4, "Runge-Kutta 4 in C++", STEPS, stability=exponential(4)),
)
TREES = "the C++ loop drives trees; the engine pinocchio closes loops"


@dataclass(frozen=True)
class Compiled(Built):
    """The model as the engine pinocchio builds it, and the same in the C++ program."""

    tree: Tree


class PinocchioCpp(Pinocchio):
    """Pinocchio's ABA inside a compiled time loop: its model, poses and reactions are those of the engine pinocchio."""

    name: ClassVar[str] = "pinocchio_cpp"
    package: ClassVar[str] = "pinocchio"
    compiles: ClassVar[bool] = True
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    takes_loads: ClassVar[bool] = False
    every: ClassVar[bool] = False  # algorithm, from the headers alone; they close loops

    def version(self) -> str:
        return described(self.every)

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = [Refusal(TREES, permanent=False)] if "closed-loop" in traits(scene) and not self.every else []
        reasons += [Refusal(obstacle(), permanent=False)] if obstacle() else []
        return reasons + super().topology_refusals(scene)

    def build(self, scene: Scene, plan: Plan) -> Compiled:
        built = super().build(scene, plan)
        tree = Tree(
            built.mechanism.model, self.every, plan.method.name.partition("_")[2] or "local", built.mechanism.contacts
        )
        return Compiled(built.mechanism, built.contact_data, built.rhs, built.start, built.breakpoints, tree)

    def first_call(self, model: Any, plan: Plan) -> None:
        model.tree.derivative(model.start)

    def advance(self, model: Any, plan: Plan) -> Loop:
        return model.tree.advance(model.start, plan)


class EveryAlgorithm(PinocchioCpp):
    """The same by each algorithm for trees and loops, so that benchmarks meet the best."""

    method_table: ClassVar[tuple[Method, ...]] = (
        *METHODS,
        Method("dop853_world", "adaptive", 8, "DOP853 in C++, ABA in world axes", RTOLS, embedded=7),
        Method("dop853_constrained", "adaptive", 8, "DOP853 in C++, constraintDynamics", RTOLS, embedded=7),
        Method("dop853_loop_aba", "adaptive", 8, "DOP853 in C++, loop-constrained ABA", RTOLS, embedded=7),
    )
    every: ClassVar[bool] = True


ENGINE = PinocchioCpp
