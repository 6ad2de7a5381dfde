"""The arrays of a tree in relative coordinates. It keeps the redundant system, which knows loads, contacts and events.

Bodies are numbered as there: a parent before its children, ground last (index n_bodies).
"""

from typing import Annotated, NamedTuple

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import handle_class, handle_in_lanes

FREE, REVOLUTE, PRISMATIC, WELD, SPHERICAL, HELD = range(6)  # HELD: a particle at a joint's point


class Joints(NamedTuple):
    """The joint between each body and its parent; d is 2 in the plane and 3 in space."""

    kind: Annotated[Ints, "n"]
    parent: Annotated[Ints, "n"]  # n for ground or none
    q: Annotated[Ints, "n"]  # first place of its coordinates in the state
    v: Annotated[Ints, "n"]  # first place of its rates
    freedoms: Annotated[Ints, "n"]
    arm: Annotated[Floats, "n", "d"]  # m, from the centre of mass to the joint's point, body axes
    arm_of_parent: Annotated[Floats, "n", "d"]  # m, the same in the parent; from the origin on ground
    axis: Annotated[Floats, "n", "d"]  # unit vector: of a revolute in the body, of a prismatic in the parent
    offset: Annotated[Floats, "n", "turn"]  # orientation in the parent at coordinate zero: rad, or Euler parameters


class Redundant(NamedTuple):
    address: Annotated[Ints, 2]  # of the handles of the redundant system's model and work


class RelativeGroups(NamedTuple):
    joints: Joints
    redundant: Redundant


class Links(NamedTuple):
    """a_body = X a_parent + S q'' + c, each a = (R'', alpha) in world axes about a centre of mass; v alike, without c.

    X (v, w) = (v + w x apart, turns w). A free body has neither X nor S nor c.
    """

    velocity: Annotated[Floats, "n + 1", "rates"]
    apart: Annotated[Floats, "n", "d"]  # m, from the parent's centre of mass to what the parent carries along
    turns: Annotated[Floats, "n"]  # 1 where the parent turns the body, 0 where it does not
    freedom: Annotated[Floats, "n", "rates"]  # S of one freedom
    bias: Annotated[Floats, "n", "rates"]  # c


class Recursion(NamedTuple):
    """Blocks of the articulated-body algorithm; `articulated` has its lower triangle in use."""

    articulated: Annotated[Floats, "n + 1", "rates", "rates"]
    force: Annotated[Floats, "n + 1", "rates"]
    answer: Annotated[Floats, "n", 3, "rates"]  # I S; of a ball the columns of H about its point
    pivot: Annotated[Floats, "n", 6]  # D = S^T I S, inverted; of a ball J about its point, factored
    drive: Annotated[Floats, "n", "rates"]  # S^T f, then q''
    acceleration: Annotated[Floats, "n + 1", "rates"]


class Full(NamedTuple):
    state: Annotated[Floats, "n_state"]  # of the redundant system
    slope: Annotated[Floats, "n_state"]


class RelativeScratch(NamedTuple):
    links: Links
    recursion: Recursion
    full: Full


TreeModel = handle_class(__name__, "TreeModel", RelativeGroups)
TreeWork = handle_class(__name__, "TreeWork", RelativeScratch)
TreeModelInLanes, TreeWorkInLanes = handle_in_lanes(TreeModel), handle_in_lanes(TreeWork)
