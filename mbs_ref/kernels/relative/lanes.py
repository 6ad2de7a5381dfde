"""A planar tree under gravity in relative coordinates, WIDTH runs of it side by side: dy/dt in lanes.

The equations are those of mbs_ref.kernels.relative.planar, compiled for lanes in place of floats.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.lanes import in_lanes, room_for_lanes
from mbs_ref.kernels.jit import inlined
from mbs_ref.kernels.planar.loads import weigh
from mbs_ref.kernels.planar.model import Bodies, Kinematics
from mbs_ref.kernels.relative.model import Joints, Links, Recursion
from mbs_ref.kernels.relative.planar import place_tree, release_tree


class Tree(NamedTuple):
    """What all runs share, and the scratch of those side by side: groups whose arrays end in WIDTH lanes."""

    joints: Joints
    bodies: Bodies
    gravity: np.ndarray  # (2,) m/s^2
    turns: np.ndarray  # (n,), of Links
    links: Links
    recursion: Recursion
    kinematics: Kinematics


def tree_in_lanes(
    joints: Joints, bodies: Bodies, gravity: np.ndarray, links: Links, recursion: Recursion, kinematics: Kinematics
) -> Tree:
    """Return a tree with scratch of its own, as large as the given scratch of one run."""
    own = Kinematics(*_rooms(kinematics))
    own.pose[-1, 2] = 1.0  # ground is not turned
    return Tree(joints, bodies, gravity, links.turns, Links(*_rooms(links)), Recursion(*_rooms(recursion)), own)


def _rooms(group: Iterable[np.ndarray]) -> list[np.ndarray]:
    return [room_for_lanes(*part.shape) for part in group]


@inlined
def derivative_in_lanes(tree, y, dy):
    """Write dy/dt of the states y, both arrays of lanes."""
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
    place_tree(tree.joints, links, kin, y)
    weigh(tree.bodies, tree.gravity, kin)
    release_tree(tree.joints, links, tree.bodies, kin, rec, y, dy)
