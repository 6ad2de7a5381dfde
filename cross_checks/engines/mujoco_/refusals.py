"""What MuJoCo cannot model, or is not yet taught."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from cross_checks.engine import Refusal
from cross_checks.engines.mujoco_.spatial_build import hinge_of
from cross_checks.workshop.planar_tree import joint_tree
from cross_checks.workshop.prescribed import constant_value
from cross_checks.workshop.spatial_tree import spatial_tree
from mbs_ref.scene import (
    Cylindrical,
    Distance,
    Force,
    Prismatic,
    Revolute,
    Scene,
    Spherical,
    SpringDamper,
    Torque,
    TorsionSpring,
    Universal,
    Weld,
)


def part_refusals(scene: Scene) -> list[Refusal]:
    reasons = []
    for load in scene.loads:
        if isinstance(load, Force | Torque) and constant_value(load.factor) is None:
            reasons.append(f"load {load.name!r} varies in time, which mujoco is not yet taught")
        if isinstance(load, SpringDamper) and load.tension_only and load.damping:
            reasons.append(f"load {load.name!r}: a mujoco tendon damps while slack, so tension_only allows no damping")
    return [Refusal(reason, permanent=False) for reason in reasons]


def closure_refusals(scene: Scene) -> list[Refusal]:
    return [
        Refusal(f"joint {joint.name!r} closes a loop by a slide, which mujoco is not yet taught", permanent=False)
        for joint in joint_tree(scene).closures
        if isinstance(joint, Prismatic)
    ]


SPATIAL_PARTS = (Spherical, Revolute, Universal, Prismatic, Cylindrical, Weld, Distance, SpringDamper, TorsionSpring)


def spatial_refusals(scene: Scene) -> list[Refusal]:
    parts = [part for part in (*scene.joints, *scene.loads) if not isinstance(part, SPATIAL_PARTS)]
    reasons = [f"{part.name!r}: mujoco is not yet taught {part.type} in space" for part in parts]
    tree = spatial_tree(scene)
    slides = [j for j in tree.closures if isinstance(j, Prismatic | Cylindrical | Universal)]
    reasons += [f"joint {joint.name!r} closes a loop by a {joint.type} joint, which mujoco is not yet taught"
                for joint in slides]  # fmt: skip
    springs = (load for load in scene.loads if isinstance(load, TorsionSpring))
    loose = [load.name for load in springs if hinge_of(tree, load) is None]
    reasons += [f"load {name!r} acts about no hinge of its bodies, which mujoco is not yet taught" for name in loose]
    return [Refusal(reason, permanent=False) for reason in reasons] + part_refusals(scene)
