"""Pinocchio: ABA in trees, proximal constraint dynamics in loops, driven from Python by RK4 or DOP853."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from cross_checks.engine import Engine, Method, Poses, Refusal
from cross_checks.engines.pinocchio_.dynamics import RightHandSide, right_hand_side
from cross_checks.engines.pinocchio_.loop import advance_adaptive, advance_fixed
from cross_checks.engines.pinocchio_.methods import GAINS, METHODS, NO_GAINS
from cross_checks.engines.pinocchio_.planar_build import Mechanism, mechanism_of
from cross_checks.engines.pinocchio_.planar_observe import poses_of, reactions_of
from cross_checks.engines.pinocchio_.spatial_build import SpatialMechanism, mechanism_in_space, start_rates
from cross_checks.engines.pinocchio_.spatial_observe import poses_in_space, reactions_in_space
from cross_checks.workshop.outcome import Loop
from cross_checks.workshop.plan import Plan
from cross_checks.workshop.planar_forces import CLIPPED_CONTACTS, SHARED, contact_refusals
from cross_checks.workshop.planar_tree import joint_tree
from cross_checks.workshop.spatial_tree import spatial_tree
from mbs_ref.scene import Drive, Revolute, Scene, Spherical, UserForce, Weld

DATA_BYTES = 32  # times n_v^3: what pinocchio.Data takes for a chain
MOST_BYTES = 1e9
CLOSING, CLOSING_IN_SPACE = (Revolute, Weld), (Spherical, Revolute, Weld)


@dataclass(frozen=True)
class Built:
    """A Pinocchio model with its right-hand side and its state (q, v) at t = 0."""

    mechanism: Mechanism | SpatialMechanism
    contact_data: Any
    rhs: RightHandSide
    start: np.ndarray
    breakpoints: list[float]  # s


class Pinocchio(Engine):
    """Pinocchio's forward dynamics under Runge-Kutta methods."""

    name: ClassVar[str] = "pinocchio"
    package: ClassVar[str] = "pinocchio"
    part_types: ClassVar[frozenset[str]] = frozenset(
        {"planar", "point_mass", "revolute", "prismatic", "weld", "distance"}
        | {"spatial", "spherical", "cylindrical", "universal"}
        | {"force", "torque", "spring_damper", "torsion_spring", "point_bushing", "user_force"}
        | {"torque_vector", "bushing"}
        | CLIPPED_CONTACTS
    )

    def methods(self) -> tuple[Method, ...]:
        return METHODS

    def version(self) -> str:
        return pin.__version__

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        closures, size = _closures_and_size(scene)
        closing = CLOSING if scene.dimension == 2 else CLOSING_IN_SPACE
        words = ", ".join(kind.model_fields["type"].default for kind in closing)
        reasons = [
            Refusal(f"joint {joint.name!r} closes a loop as {joint.type}; only {words} can", permanent=False)
            for joint in closures
            if not isinstance(joint, closing)
        ]
        if scene.dimension == 3:
            drives = [j for j in scene.joints if isinstance(j, Drive)]
            reasons += [Refusal(f"joint {j.name!r}: pinocchio has no drive; its joints are free", True) for j in drives]
            own = [load for load in scene.loads if isinstance(load, UserForce)]
            reasons += [Refusal(f"{x.name!r}: pinocchio is not yet taught {x.type} in space", False) for x in own]
        if DATA_BYTES * float(size) ** 3 > MOST_BYTES:
            needs = DATA_BYTES * float(size) ** 3 / 1e9
            reasons.append(Refusal(f"pinocchio's data take {needs:.1f} GB for {size} coordinates", True))
        return reasons + contact_refusals(scene)

    def build(self, scene: Scene, plan: Plan) -> Built:
        mechanism, start = _at_start(scene, (0.0, 0.0) if plan.method.name.endswith(NO_GAINS) else GAINS)
        contact_data = pin.StdVec_RigidConstraintData()
        rhs = right_hand_side(mechanism, contact_data)
        return Built(mechanism, contact_data, rhs, start, scene.breakpoints())

    def first_call(self, model: Built, plan: Plan) -> None:
        model.rhs(0.0, model.start)

    def advance(self, model: Built, plan: Plan) -> Loop:
        if plan.method.kind == "fixed":
            return advance_fixed(model.rhs, model.start, plan)
        return advance_adaptive(model.rhs, model.start, plan, model.breakpoints)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        in_space = isinstance(model.mechanism, SpatialMechanism)
        return (poses_in_space if in_space else poses_of)(model.mechanism, states)  # pyright: ignore[reportArgumentType]

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        observed = reactions_in_space if isinstance(model.mechanism, SpatialMechanism) else reactions_of
        times = plan.times[: len(states)]
        return observed(model.mechanism, model.rhs, model.contact_data, times, states, poses)  # pyright: ignore[reportArgumentType]

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return (SHARED,) if model.mechanism.applied else ()


ENGINE = Pinocchio


def _closures_and_size(scene: Scene) -> tuple[tuple, int]:
    """Return the joints that close loops, and the coordinates of the tree, at most."""
    if scene.dimension == 2:
        tree = joint_tree(scene)
        return tuple(tree.closures), tree.size
    return spatial_tree(scene).closures, 6 * len(scene.bodies)


def _at_start(scene: Scene, gains: tuple[float, float]) -> tuple[Mechanism | SpatialMechanism, np.ndarray]:
    """Return the model and its (q, v) at t = 0."""
    if scene.dimension == 2:
        tree = joint_tree(scene)
        return mechanism_of(tree, gains), np.concatenate((np.zeros(tree.size), tree.rates()))
    mechanism = mechanism_in_space(spatial_tree(scene), gains)
    return mechanism, np.concatenate((pin.neutral(mechanism.model), start_rates(mechanism)))
