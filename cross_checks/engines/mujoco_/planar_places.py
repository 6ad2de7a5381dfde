"""Points and names of a planar scene in a MuJoCo model."""

# Its names live in a compiled module.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import numpy as np

from cross_checks.workshop.planar_tree import JointTree, local

Z = (0.0, 0.0, 1.0)
WORLD = "world"


def hinge_name(body: str) -> str:
    return f"{body}/hinge"


def anchor(tree: JointTree, name: str, point) -> tuple[float, float, float]:
    """Return a world point at t = 0 in a body's frame."""
    k = tree.scene.body_index(name)
    return (*local(tree, k, np.array(point) - tree.position[k]), 0.0)


def add_site(spec, frames, tree: JointTree, name: str, point, label: str, turned_to_world: bool = False) -> str:
    k = tree.scene.body_index(name)
    turn = -tree.angle[k] if turned_to_world else 0.0
    quat = (np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2))
    frames[k].add_site(name=label, pos=anchor(tree, name, point), quat=quat)
    return label


def world_name(name: str) -> str:
    return WORLD if name == "ground" else name


def add_tendon(spec, frames, tree: JointTree, part):
    tendon = spec.add_tendon(name=part.name)
    for end, (body, point) in enumerate(((part.body_a, part.point_a), (part.body_b, part.point_b))):
        tendon.wrap_site(add_site(spec, frames, tree, body, point, f"{part.name}/{end}"))
    return tendon
