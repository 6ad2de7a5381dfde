"""MuJoCo: joints in a tree are exact minimal coordinates; loop closures are always soft constraints."""

from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from cross_checks.engine import Loop, Method, Plan, Poses, Refusal, end_of
from cross_checks.engines.mujoco_ import forces
from cross_checks.engines.mujoco_.build import METHODS, TIGHT, Left, advance, at_start, clock_end, compile_links
from cross_checks.engines.mujoco_.forces import Callback, Observer, passive
from cross_checks.linkage.forces import LinkageEngine
from cross_checks.linkage.links import Linkage, closure_refusals, linkage_of
from cross_checks.linkage.motion import poses_of, tree_reactions
from mbs_ref import Scene, Settings
from mbs_ref.scene.joints import Drive

NO_DRIVE = "MuJoCo prescribes motions of mocap bodies alone, which its constraints see at rest"


@dataclass(frozen=True)
class Built:
    """A MuJoCo model, its state at t = 0, and the forces it calls Python for."""

    linkage: Linkage
    model: mujoco.MjModel
    data: mujoco.MjData
    applied: Callback | None  # of a tree the shared forces, else loads that vary in time


class MuJoCo(LinkageEngine):
    """MuJoCo through MjSpec, every option pinned, the loop in C."""

    name: ClassVar[str] = "mujoco"
    package: ClassVar[str] = "mujoco"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    as_shipped: ClassVar[Settings | None] = Settings(method="euler", step=2e-3)
    extra: ClassVar[frozenset[str]] = frozenset({"stick_slip"})
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld", "rod"})
    no_equivalent: ClassVar[dict[str, str]] = {
        drive.model_fields["type"].default: NO_DRIVE for drive in Drive.__subclasses__()
    }

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        return closure_refusals(self.name, scene, self.closes) + forces.force_refusals(linkage_of(scene))

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name.endswith(TIGHT) and not reasons and not linkage_of(scene).closures:
            reasons.append(Refusal(f"{method.name} differs only where a joint closes a loop, and none does", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        shared = forces.takes_shared_forces(linkage)
        model = compile_links(linkage, plan, shared)
        return Built(linkage, model, at_start(model, linkage), forces.shared_forces(model, linkage) if shared else None)

    def first_call(self, model: Built, plan: Plan) -> None:
        with passive(model.applied):
            mujoco.mj_step(model.model, at_start(model.model, model.linkage))

    def advance(self, model: Built, plan: Plan) -> Left:
        with passive(model.applied):
            return advance(model.model, model.data, plan)

    def collect(self, model: Built, plan: Plan, left: Left) -> Loop:
        end = end_of(left.states, plan.times, clock_end(model.data, left.clock, plan))
        steps = sum(plan.counts[: max(0, end.samples - 1)])
        stages = 4 if model.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
        return Loop(left.states, end, steps, steps * stages)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        observer = Observer(model.model, model.linkage)
        with passive(model.applied):
            return poses_of(model.linkage, observer.motions(plan.times[: len(states)], states))

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        """Return none where MuJoCo's own tendons and actuators act: cfrc_int leaves them out."""
        if model.linkage.loaded and (model.applied is None or model.linkage.closures):
            return {}
        with passive(model.applied):
            wrench = Observer(model.model, model.linkage).wrenches(plan.times[: len(states)], states)
        return tree_reactions(model.linkage, poses, wrench)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return () if model.linkage.closures else super().notes(model, plan)


ENGINE = MuJoCo
