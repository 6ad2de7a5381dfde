"""Exudyn: redundant coordinates with implicit methods, or minimal coordinates (KinematicTree) with explicit ones."""

# Its items take their arguments by names that type checkers cannot see.
# pyright: reportCallIssue=false, reportArgumentType=false, reportAttributeAccessIssue=false

from __future__ import annotations

from time import perf_counter
from typing import ClassVar

import exudyn as exu
import numpy as np

from cross_checks.engine import Engine, Method, Refusal
from cross_checks.engines.exudyn_.contact import general_contact_refusals
from cross_checks.engines.exudyn_.kinematic_tree import build_tree, tree_refusals
from cross_checks.engines.exudyn_.methods import CONTACT, EXPLICIT_CONTACT, METHODS, STAGES, TREE
from cross_checks.engines.exudyn_.pair_contact import pair_contact_refusals
from cross_checks.engines.exudyn_.planar_build import build_redundant
from cross_checks.engines.exudyn_.run import advance_adaptive, advance_fixed, first_call, options_of
from cross_checks.engines.exudyn_.spatial_build import build_spatial
from cross_checks.engines.exudyn_.spatial_parts import SPATIAL_PARTS
from cross_checks.workshop.outcome import end_of, plan_run, trajectory
from cross_checks.workshop.planar_forces import CLIPPED_CONTACTS, contact_refusals
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Timing, Trajectory


class Exudyn(Engine):
    """Exudyn through its item interface; adaptive halving of the step is always off for fixed steps."""

    name: ClassVar[str] = "exudyn"
    package: ClassVar[str] = "exudyn"
    part_types: ClassVar[frozenset[str]] = frozenset(
        {"planar", "point_mass", "revolute", "prismatic", "weld", "distance", "coordinate_drive"}
        | {"force", "torque", "spring_damper", "torsion_spring"}
        | {"spatial", "spherical", "cylindrical", "torque_vector"}
        | {"point_bushing"}
        | CLIPPED_CONTACTS
        | {"sphere_on_plane", "sphere_on_sphere", "stick_slip"}
    )

    def methods(self) -> tuple[Method, ...]:
        return METHODS

    def version(self) -> str:
        return exu.__version__

    def topology_refusals(self, scene: Scene) -> list[Refusal]:
        """In space some parts of the plane are not yet taught."""
        if scene.dimension == 2:
            return []
        parts = [*scene.joints, *scene.loads]
        untaught = [part for part in parts if type(part) not in SPATIAL_PARTS]
        return [Refusal(f"{p.name!r}: exudyn is not yet taught {p.type} in space", permanent=False) for p in untaught]

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if scene.contacts and method.name in EXPLICIT_CONTACT:
            reasons += general_contact_refusals(scene) if method.name == CONTACT else pair_contact_refusals(scene)
        elif method.name in EXPLICIT_CONTACT:
            reasons += [Refusal("loads are not taught", False)] if scene.loads else []
        else:
            reasons += contact_refusals(scene)
        if scene.contacts and scene.dimension == 3 and method.name not in EXPLICIT_CONTACT:
            reasons.append(Refusal(f"contact in space is taught to {' and '.join(EXPLICIT_CONTACT)} alone", False))
        if method.name.startswith(TREE) and scene.dimension == 2:
            reasons += tree_refusals(scene)
        return reasons

    def run(self, scene: Scene, settings: Settings, times: np.ndarray | None = None) -> Trajectory:
        plan = plan_run(self, scene, settings, times)
        if isinstance(plan, Trajectory):
            return plan
        exu.config.printToConsole = False
        start = perf_counter()
        model = _build(scene, plan.method.name)
        model.mbs.Assemble()
        options = options_of(plan, scene)
        built = perf_counter()
        first_call(model, plan, options)
        called = perf_counter()
        advance = advance_fixed if plan.method.kind == "fixed" else advance_adaptive
        rows, end, steps = advance(model, plan, options, settings.max_steps)
        looped = perf_counter()
        end = end_of(rows, plan.times, end)
        return trajectory(
            plan,
            model.poses(rows),
            end,
            Timing(built - start, called - built, looped - called),
            steps=steps,
            rhs_calls=steps * STAGES.get(plan.method.name, 1),
            reactions=model.reactions(rows) if settings.reactions else {},
            notes=model.notes,
        )


ENGINE = Exudyn


def _build(scene: Scene, method: str):
    if scene.dimension == 3:
        return build_spatial(scene, method)
    return build_tree(scene) if method.startswith(TREE) else build_redundant(scene, method)
