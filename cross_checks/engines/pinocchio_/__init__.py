"""Pinocchio: ABA in trees, proximal constraint dynamics in loops, driven from Python by RK4 or DOP853."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from cross_checks.engine import Loop, Method, Plan, Poses, Refusal
from cross_checks.engines.pinocchio_ import loop
from cross_checks.engines.pinocchio_.build import Mechanism, mechanism_of
from cross_checks.engines.pinocchio_.loop import motions_of, reactions_of
from cross_checks.linkage.forces import Applied, LinkageEngine
from cross_checks.linkage.links import linkage_of
from cross_checks.linkage.motion import poses_of
from mbs_ref import Scene

DATA_BYTES = 32  # times n_v^3: what pinocchio.Data takes for a chain
MOST_BYTES = 1e9


@dataclass(frozen=True)
class Built:
    """A Pinocchio model with its right-hand side and its state (q, v) at t = 0."""

    mechanism: Mechanism
    contact_data: Any
    rhs: loop.RightHandSide
    start: np.ndarray
    breakpoints: list[float]  # s

    @property
    def applied(self) -> Applied | None:
        return self.mechanism.applied


class Pinocchio(LinkageEngine):
    """Pinocchio's forward dynamics under Runge-Kutta methods."""

    name: ClassVar[str] = "pinocchio"
    package: ClassVar[str] = "pinocchio"
    distribution: ClassVar[str] = "pin"
    method_table: ClassVar[tuple[Method, ...]] = loop.METHODS
    closes: ClassVar[frozenset[str]] = frozenset({"point", "hinge", "weld"})

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        reasons = super().topology_refusals(scene)
        size = len(linkage_of(scene).rates)
        if DATA_BYTES * float(size) ** 3 > MOST_BYTES:
            needs = DATA_BYTES * float(size) ** 3 / 1e9
            reasons.append(Refusal(f"pinocchio's data take {needs:.1f} GB for {size} coordinates", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        linkage = linkage_of(scene)
        mechanism = mechanism_of(linkage, (0.0, 0.0) if plan.method.name.endswith(loop.NO_GAINS) else loop.GAINS)
        start = np.concatenate((pin.neutral(mechanism.model), linkage.rates))
        contact_data = pin.StdVec_RigidConstraintData()
        rhs = loop.right_hand_side(mechanism, contact_data)
        return Built(mechanism, contact_data, rhs, start, scene.breakpoints())

    def first_call(self, model: Built, plan: Plan) -> None:
        model.rhs(0.0, model.start)

    def advance(self, model: Built, plan: Plan) -> Loop:
        if plan.method.kind == "fixed":
            return loop.advance_fixed(model.rhs, model.start, plan)
        return loop.advance_adaptive(model.rhs, model.start, plan, model.breakpoints)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        return poses_of(model.mechanism.linkage, motions_of(model.mechanism, states))

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        times = plan.times[: len(states)]
        return reactions_of(model.mechanism, model.rhs, model.contact_data, times, states, poses)


ENGINE = Pinocchio
