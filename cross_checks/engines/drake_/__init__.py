"""Drake: trees under its integrators in continuous time; loops under SAP and CENIC, which hold constraints."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pydrake.geometry import SceneGraph  # an optional extra
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from cross_checks.engine import Engine, Loop, Method, Plan, Refusal, stopped
from cross_checks.engines.drake_.build import Reader, Shapes, plant_of, tied_to_ground
from cross_checks.engines.drake_.run import METHODS, SAP, WORLD, advance, is_discrete, simulated
from cross_checks.isolation.parent import Isolated, Lost
from cross_checks.linkage.forces import Applied, LinkageEngine, applied, read
from cross_checks.linkage.links import Linkage, linkage_of
from mbs_ref import Scene, Settings, Status, Trajectory

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
        return advance(model.simulator, model.context, model.plant, plan)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        shared = super().notes(model, plan)
        return (*shared, ANCHORED) if plan.method.name == SAP and tied_to_ground(model.linkage) else shared


def _run_here(scene: Scene, settings: Settings, times: np.ndarray | None) -> Trajectory:
    return Engine.run(Drake(), scene, settings, times)


ENGINE = Drake
