"""OpenSim: Simbody's minimal coordinates, loops by constraints that every step is projected on."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import opensim  # an optional extra

from cross_checks.engine import End, Loop, Method, Plan, Refusal
from cross_checks.engines.opensim_ import build
from cross_checks.engines.opensim_.build import Counts, Reader, model_of
from cross_checks.linkage.forces import LinkageEngine
from cross_checks.linkage.links import Linkage, linkage_of
from mbs_ref import Status
from mbs_ref.scene import Scene, SpringDamper
from mbs_ref.scene.traits import traits

opensim.Logger.setLevelString(build.LEVEL)


@dataclass(frozen=True)
class Built:
    """An OpenSim model, its manager, and its state at t = 0."""

    linkage: Linkage
    model: Any
    manager: Any
    start: Any
    reader: Reader
    applied: None = None  # OpenSim's own springs act


class OpenSim(LinkageEngine):
    """OpenSim's Manager over Simbody."""

    name: ClassVar[str] = "opensim"
    package: ClassVar[str] = "opensim"
    method_table: ClassVar[tuple[Method, ...]] = build.METHODS
    takes_loads: ClassVar[bool] = False
    lacks: ClassVar[frozenset[str]] = frozenset({"cylindrical"})
    extra: ClassVar[frozenset[str]] = frozenset({"spring_damper"})
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld", "rod"})

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = [
            f"load {load.name!r}: opensim's spring between points has no damping and pushes as well as it pulls"
            for load in scene.loads
            if isinstance(load, SpringDamper) and (load.damping or load.tension_only)
        ]
        return super().topology_refusals(scene) + [Refusal(reason, permanent=False) for reason in reasons]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name == build.ENDLESS and "closed-loop" in traits(scene):
            reasons.append(
                Refusal(f"{method.name} makes steps of no length without end in a loop's singular pose", True)
            )
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        model, joints = model_of(linkage)
        state = model.initSystem()
        # settings count only before the manager is initialized
        manager = opensim.Manager(model)
        chosen = build.INTEGRATORS[plan.method.name.removesuffix(build.STEPPED)]
        manager.setIntegratorMethod(getattr(opensim.Manager, f"IntegratorMethod_{chosen}"))
        if plan.method.kind == "fixed":
            manager.setIntegratorFixedStepSize(plan.step)
        else:
            manager.setIntegratorAccuracy(plan.rtol)
            manager.setIntegratorMinimumStepSize(build.SHORTEST * float(plan.times[-1]))
        manager.setWriteToStorage(False)
        manager.setPerformAnalyses(False)
        manager.setRecordStatesTrajectory(False)
        return Built(linkage, model, manager, state, Reader(linkage, model, joints, state))

    def advance(self, model: Built, plan: Plan) -> Loop:
        manager = model.manager
        state = model.start
        states = np.full((len(plan.times), len(build.values(state))), np.nan)
        states[0] = build.values(state)
        state.setTime(0.0)
        manager.initialize(state)
        counts = Counts(sum(plan.counts))
        for k, t in enumerate(plan.times[1:].tolist(), start=1):
            try:
                if k == len(plan.times) - 1 and plan.method.kind == "adaptive":
                    state, counts = build.counted(manager, t)
                else:
                    state = manager.integrate(t)
            except RuntimeError as error:
                return Loop(states, _failure(error, k))
            if abs(state.getTime() - t) > 1e-9 * plan.times[-1]:
                reason = f"opensim came back at t = {state.getTime():g} s without a word"
                return Loop(states, End(k, Status.ENGINE_ERROR, reason))
            states[k] = build.values(state)
        if counts.steps > plan.max_steps:
            reason = f"max_steps = {plan.max_steps} were used up: {counts.steps} steps"
            return Loop(states, End(len(states), Status.TOO_MANY_STEPS, reason), *counts)
        return Loop(states, End(len(states)), *counts)


ENGINE = OpenSim


def _failure(error: RuntimeError, k: int) -> End:
    """Return the end before sample k in Simbody's own words, which begin after the place in its source."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and "thrown at" not in line]
    stuck = "Unable to advance time" in str(error)
    words = " ".join(lines) or "no reason given"
    return End(k, Status.STEP_TOO_SMALL if stuck else Status.ENGINE_ERROR, f"opensim stopped: {words}")
