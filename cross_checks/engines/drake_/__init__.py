"""Drake: trees under its integrators in continuous time; loops under SAP and CENIC, which hold constraints."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import SceneGraph  # an optional extra
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from cross_checks.engine import RTOLS, STEPS, End, Engine, Loop, Method, Plan, Refusal, exponential, fixed, stopped
from cross_checks.engines.drake_.build import Reader, Shapes, plant_of, tied_to_ground
from cross_checks.isolation.parent import Isolated, Lost
from cross_checks.linkage.forces import Applied, LinkageEngine, applied, read
from cross_checks.linkage.links import Linkage, linkage_of
from mbs_ref import Scene, Settings, Status, Trajectory

FIXED, SAP, WORLD, CENIC = "_fixed", "sap", "sap_world", "cenic"
TREES = frozenset({"closed-loop", "rod-in-space"})  # Drake has constraints in discrete time alone
DIES = "tied to the world body itself, constraints of discrete time end the process (SIGSEGV, seen in 1.58.0)"


def _continuous(name: str, order: int, text: str, embedded: int | None = None) -> Method:
    return Method(name, "adaptive", order, text, RTOLS, excludes=TREES, embedded=embedded)


def _stepped(name: str, order: int, text: str) -> Method:
    return Method(name + FIXED, "fixed", order, text, STEPS, excludes=TREES, stability=exponential(order))


METHODS = (
    _continuous("runge_kutta3", 3, "Drake's default: Runge-Kutta 3 with an embedded estimate", 2),
    _continuous("runge_kutta5", 5, "Runge-Kutta 5 with an embedded estimate (Dormand-Prince)", 4),
    _continuous("radau3", 3, "Radau IIA of two stages"),
    _stepped("runge_kutta3", 3, "Runge-Kutta 3 at a fixed step"),
    _stepped("runge_kutta2", 2, "Runge-Kutta 2 at a fixed step"),
    Method(SAP, "fixed", 1, "discrete time: symplectic Euler, constraints by SAP", STEPS),
    fixed(WORLD, 1, "the same, loops to ground closed at Drake's own world body", wrong_limit=DIES, weak_on=TREES),
    Method(CENIC, "adaptive", 1, "CENIC: SAP's convex step under error control", RTOLS[:3]),
)


Wrenches = Callable[[float, np.ndarray], np.ndarray]


class Loads(LeafSystem):
    """Forces and torques (n_bodies, 6) of time and state as forces at the centres of mass."""

    def __init__(self, wrenches: Wrenches, reader: Reader, size: int) -> None:
        super().__init__()
        self.wrenches, self.reader = wrenches, reader
        self.state = self.DeclareVectorInputPort("state", size)
        none = Value([ExternallyAppliedSpatialForce()])
        self.DeclareAbstractOutputPort("forces", lambda: none.Clone(), self._fill)

    def _fill(self, context: Any, output: Any) -> None:
        state = self.state.Eval(context)
        if not np.isfinite(state).all():  # reading it would end the process
            raise RuntimeError(f"the state is not finite at t = {context.get_time():g} s")
        wrenches = self.wrenches(context.get_time(), state)
        forces = []
        for body, centre, wrench in zip(self.reader.bodies, self.reader.centres, wrenches, strict=True):
            force = ExternallyAppliedSpatialForce()
            force.body_index, force.p_BoBq_B = body.index(), centre
            force.F_Bq_W = SpatialForce(wrench[3:], wrench[:3])
            forces.append(force)
        output.set_value(forces)


def is_discrete(plan: Plan) -> bool:
    """Return whether the plant itself steps in time."""
    return plan.method.kind == "fixed" and not plan.method.name.endswith(FIXED)


def simulated(
    plant: MultibodyPlant, reader: Reader, wrenches: Wrenches | None, plan: Plan, graph: SceneGraph | None = None
) -> tuple[Simulator, Any]:
    """Return a simulator whose integrator is chosen, and the plant's part of its context.

    A scene graph holds the plant's shapes that may touch.
    """
    if wrenches is None and graph is None:
        simulator = Simulator(plant)
        context = simulator.get_mutable_context()
    else:
        builder = DiagramBuilder()
        builder.AddSystem(plant)
        if graph is not None:
            builder.AddSystem(graph)
            builder.Connect(graph.get_query_output_port(), plant.get_geometry_query_input_port())
            poses = graph.get_source_pose_port(plant.get_source_id())
            builder.Connect(plant.get_geometry_pose_output_port(), poses)
        if wrenches is not None:
            loads = builder.AddSystem(Loads(wrenches, reader, plant.num_multibody_states()))
            builder.Connect(plant.get_state_output_port(), loads.get_input_port())
            builder.Connect(loads.get_output_port(), plant.get_applied_spatial_force_input_port())
        simulator = Simulator(builder.Build())
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    if not is_discrete(plan):
        # A largest step of 10 ms, which is common, hides the accuracy: here it is the output interval
        fixed = plan.method.kind == "fixed"
        largest = plan.step if fixed else float(np.diff(plan.times).max())
        integrator = ResetIntegratorFromFlags(simulator, plan.method.name.removesuffix(FIXED), largest)
        integrator.set_fixed_step_mode(fixed)
        if not fixed:
            integrator.set_target_accuracy(plan.rtol)
    return simulator, context


def _landings(plan: Plan) -> Iterator[list[float]]:
    """Yield the times to advance to, for each output time after the first.

    A discrete update belongs to the time where it begins: half a step earlier, no roundoff takes one too many.
    """
    n = 0
    for k, t in enumerate(plan.times[1:].tolist()):
        count = plan.counts[k] if plan.counts else 1
        if is_discrete(plan):
            yield [(n + count - 0.5) * plan.step]
        else:
            yield [*((n + i) * plan.step for i in range(1, count)), t]
        n += count


def _counts(simulator: Simulator, plan: Plan, reached: int) -> tuple[int, int, int]:
    """Return steps, right-hand sides and rejected steps."""
    if is_discrete(plan):
        steps = sum(plan.counts[:reached])
        return steps, steps, 0
    integrator = simulator.get_integrator()
    rejected = integrator.get_num_step_shrinkages_from_error_control()
    return integrator.get_num_steps_taken(), integrator.get_num_derivative_evaluations(), rejected


ANCHORED = "loops to ground are closed at a body welded to the world: at the world itself drake's process dies"


@dataclass(frozen=True)
class Built:
    """A plant, what reads its states, and its simulator at t = 0 with the plant's part of its context."""

    linkage: Linkage
    plant: MultibodyPlant
    reader: Reader
    applied: Applied | None
    simulator: Simulator
    context: Any


class Drake(LinkageEngine):
    """Drake's MultibodyPlant under its own simulator."""

    name: ClassVar[str] = "drake"
    package: ClassVar[str] = "pydrake"
    distribution: ClassVar[str] = "drake"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    lacks: ClassVar[frozenset[str]] = frozenset({"cylindrical"})
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld", "rod"})

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name == WORLD and not reasons and not tied_to_ground(linkage_of(scene)):
            reasons.append(Refusal(f"{method.name} differs only where a loop is closed at ground, and none is", True))
        if method.excludes and not reasons:
            rods = [closure.name for closure in linkage_of(scene).closures]
            kept = "a constraint, which Drake keeps in discrete time alone"
            reasons += [Refusal(f"{method.name}: joint {name!r} is {kept}", True) for name in rods]
        return reasons

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        """Execute the runs that are known to end the process in a process of their own."""
        if self.method(settings.method).name != WORLD:
            return super().run(scene, settings, times)
        with Isolated() as apart:
            try:
                return apart(_run_here, scene, settings, times)
            except Lost as lost:
                return stopped(scene, Status.ENGINE_ERROR, f"drake did not come back: {lost}")

    def build(self, scene: Scene, plan: Plan, shapes: tuple[Shapes, SceneGraph] | None = None) -> Built:
        linkage = linkage_of(scene)
        loads = applied(linkage)
        step = plan.step if is_discrete(plan) else 0.0
        # with loads, gravity comes with them from the one system of applied forces
        gravity = linkage.gravity if loads is None else np.zeros(3)
        add_shapes, graph = shapes or (None, None)
        to_world = plan.method.name == WORLD or not is_discrete(plan)
        plant = plant_of(linkage, step, gravity, to_world, add_shapes)
        reader = Reader(plant, linkage)
        acting = None if loads is None else lambda t, state: loads.wrenches(t, read(linkage, reader, state))
        simulator, context = simulated(plant, reader, acting, plan, graph)
        plant.SetPositionsAndVelocities(context, reader.start(linkage))
        return Built(linkage, plant, reader, loads, simulator, context)

    def first_call(self, model: Built, plan: Plan) -> None:
        model.simulator.Initialize()

    def advance(self, model: Built, plan: Plan) -> Loop:
        """Land on every output time, in continuous time on every fixed step: its own clock adds up roundoff."""
        simulator, context, plant = model.simulator, model.context, model.plant
        states = np.full((len(plan.times), plant.num_multibody_states()), np.nan)
        states[0] = plant.GetPositionsAndVelocities(context)
        for k, landings in enumerate(_landings(plan), start=1):
            try:
                for t in landings:
                    simulator.AdvanceTo(t)
            except RuntimeError as error:
                line = str(error).splitlines()[0]
                short = "minimum" in str(error) or "step size" in str(error)
                status = Status.STEP_TOO_SMALL if short else Status.ENGINE_ERROR
                return Loop(states, End(k, status, f"drake stopped: {line}"), *_counts(simulator, plan, k))
            states[k] = plant.GetPositionsAndVelocities(context)
            if not is_discrete(plan) and simulator.get_integrator().get_num_steps_taken() > plan.max_steps:
                used = f"max_steps = {plan.max_steps} were used up at t = {plan.times[k]:g} s"
                return Loop(states, End(k + 1, Status.TOO_MANY_STEPS, used), *_counts(simulator, plan, k))
        return Loop(states, End(len(states)), *_counts(simulator, plan, len(states) - 1))

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        shared = super().notes(model, plan)
        return (*shared, ANCHORED) if plan.method.name == SAP and tied_to_ground(model.linkage) else shared


def _run_here(scene: Scene, settings: Settings, times: np.ndarray | None) -> Trajectory:
    return Engine.run(Drake(), scene, settings, times)


ENGINE = Drake
