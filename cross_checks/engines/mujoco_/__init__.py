"""MuJoCo: joints in a tree are exact minimal coordinates; loop closures are always soft constraints."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from cross_checks.engine import Engine, Method, Poses, Refusal
from cross_checks.engines.mujoco_.contact import contact_refusals
from cross_checks.engines.mujoco_.methods import METHODS, STOCK, TIGHT
from cross_checks.engines.mujoco_.observe import observe_planar, observe_spatial, wrenches
from cross_checks.engines.mujoco_.planar_build import compile_planar
from cross_checks.engines.mujoco_.refusals import closure_refusals, spatial_refusals
from cross_checks.engines.mujoco_.run import Left, advance, at_start, clock_end
from cross_checks.engines.mujoco_.shared_forces import (
    Callback,
    force_refusals,
    passive,
    shared_forces,
    takes_shared_forces,
)
from cross_checks.engines.mujoco_.spatial_build import compile_spatial
from cross_checks.workshop.outcome import Loop, end_of
from cross_checks.workshop.plan import Plan
from cross_checks.workshop.planar_forces import CLIPPED_CONTACTS, SHARED
from cross_checks.workshop.planar_reactions import tree_reactions
from cross_checks.workshop.planar_tree import JointTree, joint_tree
from cross_checks.workshop.spatial_tree import SpatialTree, spatial_tree
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings


@dataclass(frozen=True)
class Built:
    """A MuJoCo model, its state at t = 0, and the forces it calls Python for."""

    tree: JointTree | SpatialTree
    model: mujoco.MjModel
    data: mujoco.MjData
    act: Callback | None


class MuJoCo(Engine):
    """MuJoCo through MjSpec, every option pinned, the loop in C."""

    name: ClassVar[str] = "mujoco"
    package: ClassVar[str] = "mujoco"
    as_shipped: ClassVar[Settings | None] = Settings(method="euler", step=2e-3)
    part_types: ClassVar[frozenset[str]] = frozenset(
        {"planar", "point_mass", "revolute", "prismatic", "weld", "distance"}
        | {"force", "torque", "spring_damper", "torsion_spring"}
        | {"spatial", "spherical", "cylindrical", "universal"}
        | {"point_bushing"}
        | CLIPPED_CONTACTS
        | {"sphere_on_plane", "sphere_on_sphere", "stick_slip"}
    )

    def methods(self) -> tuple[Method, ...]:
        return METHODS

    def version(self) -> str:
        return mujoco.__version__

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        if scene.dimension == 3:
            return spatial_refusals(scene) + contact_refusals(scene)
        return closure_refusals(scene) + force_refusals(scene)

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name.endswith(TIGHT) and not reasons and not _closures(scene):
            reasons.append(Refusal(f"{method.name} differs only where a joint closes a loop, and none does", True))
        if method.name.endswith(STOCK) and not scene.contacts:
            reasons.append(Refusal(f"{method.name} differs only in contact, and there is none", True))
        if method.name.endswith(STOCK) and takes_shared_forces(scene):
            reasons.append(Refusal(f"{method.name} differs only in MuJoCo's own contacts, and {SHARED}", True))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        tree = joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)
        model = compile_planar(tree, plan) if isinstance(tree, JointTree) else compile_spatial(tree, plan)
        shared = isinstance(tree, JointTree) and takes_shared_forces(scene)
        act = shared_forces(model, tree) if isinstance(tree, JointTree) and shared else None
        return Built(tree, model, at_start(model, tree), act)

    def first_call(self, model: Built, plan: Plan) -> None:
        with passive(model.act):
            mujoco.mj_step(model.model, at_start(model.model, model.tree))

    def advance(self, model: Built, plan: Plan) -> Left:
        with passive(model.act):
            return advance(model.model, model.data, plan)

    def collect(self, model: Built, plan: Plan, left: Left) -> Loop:
        end = end_of(left.states, plan.times, clock_end(model.data, left.clock, plan))
        steps = sum(plan.counts[: max(0, end.samples - 1)])
        stages = 4 if model.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
        return Loop(left.states, end, steps, steps * stages)

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        if isinstance(model.tree, SpatialTree):
            return observe_spatial(model.model, model.tree, states)
        with passive(model.act):
            return observe_planar(model.model, model.tree, plan.times[: len(states)], states)

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        """Return none where MuJoCo's own tendons and actuators act: cfrc_int leaves them out."""
        scene = model.tree.scene
        if isinstance(model.tree, SpatialTree) or ((scene.loads or scene.contacts) and model.act is None):
            return {}
        with passive(model.act):
            wrench = wrenches(model.model, model.tree, plan.times[: len(states)], states)
        return tree_reactions(model.tree, poses, wrench)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        return (SHARED,) if model.act else ()


ENGINE = MuJoCo


def _closures(scene: Scene) -> tuple:
    return tuple((joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)).closures)
