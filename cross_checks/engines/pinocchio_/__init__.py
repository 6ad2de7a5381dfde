"""Pinocchio: ABA in trees, proximal constraint dynamics in loops, driven from Python by RK4 or DOP853."""

# It is installed under a prefix that only the interpreter knows.
# pyright: reportMissingImports=false

from __future__ import annotations

from time import perf_counter
from typing import ClassVar

import numpy as np
import pinocchio as pin

from cross_checks.engine import Engine, Method, Refusal
from cross_checks.engines.pinocchio_.dynamics import right_hand_side
from cross_checks.engines.pinocchio_.loop import advance_adaptive, advance_fixed
from cross_checks.engines.pinocchio_.methods import DRIVEN, GAINS, METHODS, NO_GAINS
from cross_checks.engines.pinocchio_.planar_build import Mechanism, mechanism_of
from cross_checks.engines.pinocchio_.planar_observe import poses_of, reactions_of
from cross_checks.engines.pinocchio_.spatial_build import SpatialMechanism, mechanism_in_space, start_rates
from cross_checks.engines.pinocchio_.spatial_observe import poses_in_space, reactions_in_space
from cross_checks.workshop.outcome import plan_run, trajectory
from cross_checks.workshop.planar_forces import CLIPPED_CONTACTS, contact_refusals
from cross_checks.workshop.planar_tree import joint_tree
from cross_checks.workshop.spatial_tree import spatial_tree
from mbs_ref.scene import DRIVES, Revolute, Scene, Spherical, UserForce, Weld
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Timing, Trajectory

DATA_BYTES = 32  # times n_v^3: what pinocchio.Data takes for a chain
MOST_BYTES = 1e9
CLOSING, CLOSING_IN_SPACE = (Revolute, Weld), (Spherical, Revolute, Weld)


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
            drives = [j for j in scene.joints if isinstance(j, DRIVES)]
            reasons += [Refusal(f"joint {j.name!r}: pinocchio has no drive; its joints are free", True) for j in drives]
            own = [load for load in scene.loads if isinstance(load, UserForce)]
            reasons += [Refusal(f"{x.name!r}: pinocchio is not yet taught {x.type} in space", False) for x in own]
        if DATA_BYTES * float(size) ** 3 > MOST_BYTES:
            needs = DATA_BYTES * float(size) ** 3 / 1e9
            reasons.append(Refusal(f"pinocchio's data take {needs:.1f} GB for {size} coordinates", True))
        return reasons + contact_refusals(scene)

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        plan = plan_run(self, scene, settings, times)
        if isinstance(plan, Trajectory):
            return plan
        start = perf_counter()
        mechanism, initial = _at_start(scene, (0.0, 0.0) if plan.method.name.endswith(NO_GAINS) else GAINS)
        contact_data = pin.StdVec_RigidConstraintData()
        rhs = right_hand_side(mechanism, contact_data)
        built = perf_counter()
        rhs(0.0, initial)
        called = perf_counter()
        advance = advance_fixed if plan.method.kind == "fixed" else advance_adaptive
        states, end, steps, calls = advance(rhs, initial, plan, settings.max_steps, scene.breakpoints())
        looped = perf_counter()
        states, reached = states[: end.samples], plan.times[: end.samples]
        if isinstance(mechanism, SpatialMechanism):
            poses, observed = poses_in_space(mechanism, states), reactions_in_space
        else:
            poses, observed = poses_of(mechanism, states), reactions_of
        return trajectory(
            plan,
            poses,
            end,
            Timing(built - start, called - built, looped - called),
            steps=steps,
            rhs_calls=calls,
            reactions=observed(mechanism, rhs, contact_data, reached, states, poses) if settings.reactions else {},  # pyright: ignore[reportArgumentType]
            notes=(DRIVEN,) + (("loads and contacts come from the shared force code",) if mechanism.applied else ()),
        )


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
