"""Pinocchio as its users drive it: a loop in C++ over its own headers, for trees that gravity alone moves."""

from dataclasses import dataclass
from typing import Any, ClassVar

from cross_checks.engine import RTOLS, STEPS, Loop, Method, Plan, Refusal, exponential
from cross_checks.engines.pinocchio_ import Built, Pinocchio
from cross_checks.engines.pinocchio_cpp_.compiler import described, obstacle
from cross_checks.engines.pinocchio_cpp_.native import Tree
from mbs_ref import Scene
from mbs_ref.scene.traits import traits

METHODS = (
    Method("dop853", "adaptive", 8, "DOP853 in C++ with the step control of SciPy's", RTOLS, embedded=7),
    Method("rk4", "fixed", 4, "Runge-Kutta 4 in C++", STEPS, stability=exponential(4)),
)
FORMS = {"dop853_world": "world", "dop853_constrained": "constrained", "dop853_loop_aba": "loop_aba"}
TREES = "the C++ loop drives trees; the engine pinocchio closes loops"


@dataclass(frozen=True)
class Compiled(Built):
    """The model as the engine pinocchio builds it, and the same in the C++ program."""

    tree: Tree


class PinocchioCpp(Pinocchio):
    """Pinocchio's ABA inside a compiled time loop: its model, poses and reactions are those of the engine pinocchio."""

    name: ClassVar[str] = "pinocchio_cpp"
    package: ClassVar[str] = "pinocchio"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    takes_loads: ClassVar[bool] = False
    every: ClassVar[bool] = False  # algorithm, from the headers alone; they close loops

    def version(self) -> str:
        return described(self.every)

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = [Refusal(TREES, permanent=False)] if self.is_beyond(scene) else []
        reasons += [Refusal(obstacle(), permanent=False)] if obstacle() else []
        return reasons + super().topology_refusals(scene)

    def is_beyond(self, scene: Scene) -> bool:
        """Return whether the scene has loops that this engine does not close."""
        return "closed-loop" in traits(scene) and not self.every

    def build(self, scene: Scene, plan: Plan) -> Compiled:
        built = super().build(scene, plan)
        tree = Tree(built.mechanism.model, self.every, FORMS.get(plan.method.name, "local"), built.mechanism.contacts)
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
