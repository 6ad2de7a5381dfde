"""Exudyn: redundant coordinates with implicit methods, or minimal coordinates (KinematicTree) with explicit ones."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import exudyn as exu
import numpy as np

from cross_checks.engine import Engine, Loop, Method, Plan, Poses, Refusal
from cross_checks.engines.exudyn_ import run as solver
from cross_checks.engines.exudyn_.build import ROTATION_VECTOR, build_redundant, takes_shared_forces
from cross_checks.engines.exudyn_.contact import general_contact_refusals, pair_contact_refusals
from cross_checks.engines.exudyn_.kinematic_tree import build_tree, tree_refusals
from cross_checks.engines.exudyn_.parts import JOINTS
from cross_checks.engines.exudyn_.run import CONTACT, EXPLICIT_CONTACT, METHODS, STAGES, TREE, Left
from cross_checks.linkage.forces import PARTS, shared_refusals
from mbs_ref import Settings
from mbs_ref.scene import CoordinateDrive, Scene
from mbs_ref.scene.traits import traits


@dataclass(frozen=True)
class Built:
    """An assembled system, and the options of its solver."""

    model: Any  # Redundant or Tree
    options: Any
    loops: bool
    left: list[Left] = field(default_factory=list)  # what the run left, once it is over


class Exudyn(Engine):
    """Exudyn through its item interface; adaptive halving of the step is always off for fixed steps."""

    name: ClassVar[str] = "exudyn"
    package: ClassVar[str] = "exudyn"
    method_table: ClassVar[tuple[Method, ...]] = METHODS
    as_shipped: ClassVar[Settings | None] = Settings(method="generalized_alpha", step=1e-2)
    part_types: ClassVar[frozenset[str]] = PARTS | {"coordinate_drive", "stick_slip"}

    def method_refusals(self, scene: Scene, method: Method) -> list[Refusal]:
        reasons = super().method_refusals(scene, method)
        if method.name in EXPLICIT_CONTACT:
            sentence = f"load {{!r}}: {method.name} does not yet support {{}}"
            reasons += [Refusal(sentence.format(load.name, load.type), False) for load in scene.loads]
            reasons += general_contact_refusals(scene) if method.name == CONTACT else pair_contact_refusals(scene)
        else:
            reasons += shared_refusals(scene)
        if method.name.startswith(TREE):
            return reasons + tree_refusals(scene)
        drives = (CoordinateDrive,) if scene.dimension == 3 else ()
        strange = [joint for joint in scene.joints if type(joint) not in JOINTS or isinstance(joint, drives)]
        sentence = f"joint {{!r}}: {method.name} does not yet support {{}}"
        reasons += [Refusal(sentence.format(joint.name, joint.type), False) for joint in strange]
        if method.name == ROTATION_VECTOR and takes_shared_forces(scene, method.name):
            reasons.append(Refusal(f"{method.name}: the shared force code lacks rotation vectors", False))
        return reasons

    def build(self, scene: Scene, plan: Plan) -> Built:
        exu.config.printToConsole = False
        name = plan.method.name
        model = build_tree(scene) if name.startswith(TREE) else build_redundant(scene, name)
        model.mbs.Assemble()
        options = solver.options_of(plan, scene, dense=solver.needs_dense(model.mbs, scene))
        return Built(model, options, "closed-loop" in traits(scene))

    def first_call(self, model: Built, plan: Plan) -> None:
        solver.first_call(model.model, plan, model.options)

    def advance(self, model: Built, plan: Plan) -> Left:
        if plan.method.kind == "fixed":
            return solver.advance_fixed(model.model, plan, model.options, loops=model.loops)
        return solver.advance_adaptive(model.model, plan, model.options)

    def collect(self, model: Built, plan: Plan, left: Left) -> Loop:
        sampled = solver.sampled_fixed if plan.method.kind == "fixed" else solver.sampled_adaptive
        rows, end = sampled(model.model, plan, left)
        model.left.append(left)
        return Loop(rows, end, left.steps, left.steps * STAGES.get(plan.method.name, 1))

    def poses(self, model: Built, plan: Plan, states: np.ndarray) -> Poses:
        return model.model.poses(states)

    def reactions(self, model: Built, plan: Plan, states: np.ndarray, poses: Poses) -> dict[str, np.ndarray]:
        return model.model.reactions(states)

    def notes(self, model: Built, plan: Plan) -> tuple[str, ...]:
        retried = [left.retried for left in model.left if left.retried]
        return model.model.notes + tuple(f"sparse elimination stopped, and dense began anew: {why}" for why in retried)


ENGINE = Exudyn
