"""MuJoCo: joints in a tree are exact minimal coordinates; loop closures are always soft constraints."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from contextlib import nullcontext
from time import perf_counter
from typing import ClassVar

import mujoco
import numpy as np

from cross_checks.engine import Engine, Method, Refusal
from cross_checks.engines.mujoco_.contact import contact_refusals
from cross_checks.engines.mujoco_.methods import METHODS, STOCK, TIGHT
from cross_checks.engines.mujoco_.observe import observe_planar, observe_spatial
from cross_checks.engines.mujoco_.planar_build import compile_planar
from cross_checks.engines.mujoco_.refusals import closure_refusals, spatial_refusals
from cross_checks.engines.mujoco_.run import advance, at_start
from cross_checks.engines.mujoco_.shared_forces import SHARED, force_refusals, shared_forces, takes_shared_forces
from cross_checks.engines.mujoco_.spatial_build import compile_spatial
from cross_checks.workshop.outcome import plan_run, trajectory
from cross_checks.workshop.planar_forces import CLIPPED_CONTACTS
from cross_checks.workshop.planar_reactions import tree_reactions
from cross_checks.workshop.planar_tree import JointTree, joint_tree
from cross_checks.workshop.spatial_tree import SpatialTree, spatial_tree
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Timing, Trajectory


class MuJoCo(Engine):
    """MuJoCo through MjSpec, every option pinned, the loop in C."""

    name: ClassVar[str] = "mujoco"
    package: ClassVar[str] = "mujoco"
    part_types: ClassVar[frozenset[str]] = frozenset(
        {"planar", "point_mass", "revolute", "prismatic", "weld", "distance"}
        | {"force", "torque", "spring_damper", "torsion_spring"}
        | {"spatial", "spherical", "cylindrical"}
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

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        plan = plan_run(self, scene, settings, times)
        if isinstance(plan, Trajectory):
            return plan
        start = perf_counter()
        tree = joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)
        model = compile_planar(tree, plan) if isinstance(tree, JointTree) else compile_spatial(tree, plan)
        data = at_start(model, tree)
        shared = isinstance(tree, JointTree) and takes_shared_forces(scene)
        forces = shared_forces(model, tree) if isinstance(tree, JointTree) and shared else nullcontext()
        built = perf_counter()
        with forces:
            advance(model, at_start(model, tree), plan, 1)
            called = perf_counter()
            states, end = advance(model, data, plan, len(plan.times))
            looped = perf_counter()
            states = states[: end.samples]
            if isinstance(tree, SpatialTree):
                poses, reactions = observe_spatial(model, tree, states), {}
            else:
                poses, wrench = observe_planar(model, tree, plan.times[: end.samples], states)
                bare = not scene.loads and not scene.contacts  # cfrc_int leaves out tendons and actuators
                known = settings.reactions and (bare or shared)
                reactions = tree_reactions(tree, poses, wrench) if known else {}
        steps = sum(plan.counts[: max(0, end.samples - 1)])
        stages = 4 if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 1
        return trajectory(
            plan,
            poses,
            end,
            Timing(built - start, called - built, looped - called),
            steps=steps,
            rhs_calls=steps * stages,
            reactions=reactions,
            notes=(SHARED,) if shared else (),
        )


ENGINE = MuJoCo


def _closures(scene: Scene) -> tuple:
    return tuple((joint_tree(scene) if scene.dimension == 2 else spatial_tree(scene)).closures)
