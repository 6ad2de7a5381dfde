"""Planar trees of one build under gravity in relative coordinates, WIDTH runs side by side: dy/dt in lanes.

The equations are those of mbs_ref.kernels.relative.planar, compiled for lanes in place of floats. Trees of one build
differ in their figures alone: masses, inertias, joints' places, axes and offsets, gravity.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.lanes import WIDTH, in_lanes, room_for_lanes
from mbs_ref.kernels.jit import inlined
from mbs_ref.kernels.planar.marks import weigh
from mbs_ref.kernels.planar.model import Kinematics
from mbs_ref.kernels.relative.model import Joints, Links, Recursion
from mbs_ref.kernels.relative.planar import place_tree, release_tree
from mbs_ref.kernels.rigid.model import Bodies


class Figures(NamedTuple):
    """A planar tree: its build, whole numbers that trees in lanes share, and its figures, floats that each has."""

    joints: Joints
    bodies: Bodies
    gravity: np.ndarray  # (2,) m/s^2


class Tree(NamedTuple):
    """The trees of the runs side by side and their scratch: groups whose floats end in WIDTH lanes."""

    figures: np.ndarray  # (n_figures, WIDTH), that of the groups below
    joints: Joints
    bodies: Bodies
    gravity: np.ndarray  # (2, WIDTH) m/s^2
    turns: np.ndarray  # (n,), of Links
    links: Links
    recursion: Recursion
    kinematics: Kinematics


def figures_of(given: Figures) -> np.ndarray:
    """Return the figures of a tree (n_figures,)."""
    return np.concatenate([part.ravel() for part in _arrays(given) if part.dtype == np.float64])


def build_of(given: Figures) -> bytes:
    """Return what trees must have in common to be side by side."""
    return b"".join(part.tobytes() for part in _arrays(given) if part.dtype != np.float64)


def _arrays(given: Figures) -> Iterator[np.ndarray]:
    yield from (*given.joints, *given.bodies, given.gravity)


def tree_in_lanes(given: Figures, links: Links, recursion: Recursion, kinematics: Kinematics) -> Tree:
    """Return room for WIDTH trees of one build, as large as the given scratch of one run; lanes have no figures yet."""
    figures, taken = room_for_lanes(len(figures_of(given))), 0

    def placed(part: np.ndarray) -> np.ndarray:
        nonlocal taken
        if part.dtype != np.float64:
            return part
        first, taken = taken, taken + part.size
        return figures[first:taken].reshape(*part.shape, WIDTH)

    joints, bodies = Joints(*map(placed, given.joints)), Bodies(*map(placed, given.bodies))
    own = Kinematics(*_rooms(kinematics))
    own.pose[-1, 2] = 1.0  # ground is not turned
    scratch = Links(*_rooms(links)), Recursion(*_rooms(recursion)), own
    return Tree(figures, joints, bodies, placed(given.gravity), links.turns, *scratch)


def _rooms(group: Iterable[np.ndarray]) -> list[np.ndarray]:
    return [room_for_lanes(*part.shape) for part in group]


@inlined
def derivative_in_lanes(tree, y, dy):
    """Write dy/dt of the states y, both arrays of lanes."""
    shared, gravity = tree.joints, in_lanes(tree.gravity)
    joints = Joints(
        shared.kind, shared.parent, shared.q, shared.v, shared.freedoms, in_lanes(shared.arm),
        in_lanes(shared.arm_of_parent), in_lanes(shared.axis), in_lanes(shared.offset),
    )  # fmt: skip
    bodies = Bodies(
        in_lanes(tree.bodies.mass), in_lanes(tree.bodies.inertia), tree.bodies.rigid, tree.bodies.alone,
        tree.bodies.scene_index, tree.bodies.q, tree.bodies.v, tree.bodies.start, tree.bodies.parent,
    )  # fmt: skip
    links = Links(
        in_lanes(tree.links.velocity), in_lanes(tree.links.apart), tree.turns, in_lanes(tree.links.freedom),
        in_lanes(tree.links.bias),
    )  # fmt: skip
    rec = Recursion(
        in_lanes(tree.recursion.articulated), in_lanes(tree.recursion.force), in_lanes(tree.recursion.answer),
        in_lanes(tree.recursion.pivot), in_lanes(tree.recursion.drive), in_lanes(tree.recursion.acceleration),
    )  # fmt: skip
    kin = Kinematics(
        in_lanes(tree.kinematics.pose), in_lanes(tree.kinematics.motion), in_lanes(tree.kinematics.force),
        in_lanes(tree.kinematics.user),
    )  # fmt: skip
    place_tree(joints, links, kin, y)
    weigh(bodies, gravity, kin)
    release_tree(joints, links, bodies, kin, rec, y, dy)
