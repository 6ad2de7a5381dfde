"""Newton (Linux Foundation, on NVIDIA Warp): several solvers behind one model, here on the CPU and in single precision.

The distributions are `newton` and `warp-lang`. Warp compiles each solver's kernels once, for minutes, and keeps them in
the cache folder. A step is recorded (an APIC capture) and replayed in C++, a hundred times as fast as from Python.

Not implemented: MuJoCo-Warp, which Newton's extra `sim` brings; XPBD, whose states are poses that count no turns, and
which makes velocities of differences of positions over a step, so that rounding grows as steps shrink (seen in 1.8.0).
"""

from dataclasses import dataclass
from typing import Any, ClassVar

from cross_checks.engines.newton_.model import DEVICE, Reader, model_of, row_of  # sets Warp up before Newton imports it

# isort: split
import newton
import numpy as np
import warp
from numba.core.event import trigger_event

from cross_checks.engine import SINGLE, STEPS, End, Loop, Method, Plan
from cross_checks.linkage.forces import LinkageEngine
from cross_checks.linkage.links import Linkage, linkage_of
from mbs_ref import Scene

FEATHERSTONE = "featherstone"
FLOAT32 = "Newton computes in single precision: n steps leave up to 6e-8 n of rounding"
METHODS = (
    Method(FEATHERSTONE, "fixed", 1, "symplectic Euler on joint coordinates", STEPS, roundoff=SINGLE),
)  # fmt: skip
SOLVERS: dict[str, tuple[str, dict[str, Any]]] = {  # class, options
    FEATHERSTONE: ("SolverFeatherstone", {"angular_damping": 0.0})  # 0.05 by default, which 1.8.0 does not read
}


@dataclass
class Built:
    """A model, its solver, two states that take turns, and the recorded steps from one to the other."""

    linkage: Linkage
    model: Any
    solver: Any
    states: tuple[Any, Any]
    reader: Reader
    steps: tuple[Any, ...] = ()


class Newton(LinkageEngine):
    """Newton's solvers of articulated bodies, without contact."""

    name: ClassVar[str] = "newton"
    package: ClassVar[str] = "newton"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    takes_loads: ClassVar[bool] = False

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        kind, options = SOLVERS[plan.method.name]
        with trigger_event("numba:compile"):  # who waits for a run sees that it compiles
            model = model_of(linkage)
            solver = getattr(newton.solvers, kind)(model, **options)
            built = Built(linkage, model, solver, (model.state(), model.state()), Reader(linkage, model))
            _to_start(built)
        return built

    def first_call(self, model: Built, plan: Plan) -> None:
        """Compile, and record a step from each state to the other; recording makes none."""
        here, there = model.states
        control = model.model.control()
        with trigger_event("numba:compile"):
            model.solver.step(here, there, control, None, plan.step)
        recorded = []
        for before, after in ((here, there), (there, here)):
            with warp.ScopedCapture(device=DEVICE) as capture:
                model.solver.step(before, after, control, None, plan.step)
            recorded.append(capture.graph)
        model.steps = tuple(recorded)
        _to_start(model)

    def advance(self, model: Built, plan: Plan) -> Loop:
        states = np.empty((len(plan.times), row_of(model.states[0]).size))
        states[0] = row_of(model.states[0])
        done = 0
        for k, count in enumerate(plan.counts, start=1):
            for _ in range(count):
                warp.capture_launch(model.steps[done % 2])
                done += 1
            states[k] = row_of(model.states[done % 2])
        return Loop(states, End(len(states)), done, done)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return (FLOAT32,)


ENGINE = Newton


def _to_start(built: Built) -> None:
    model = built.model
    for state in built.states:
        state.assign(model.state())
        newton.eval_fk(model, model.joint_q, model.joint_qd, state)
