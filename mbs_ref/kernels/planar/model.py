"""The arrays of a compiled planar scene, one homogeneous group per element type.

See `rigid.model` for the numbering.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import accessor
from mbs_ref.kernels.contact.laws import ContactLaws, ContactModes
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.rigid.closures import Closures, Loops
from mbs_ref.kernels.rigid.model import Rows, Solved, Springs, Watches, World
from mbs_ref.kernels.signals import SignalArrays

RATES = tuple(range(3))  # of a body: a loop over it has bounds that the compiler knows


class Bodies(NamedTuple):
    mass: Annotated[Floats, "n"]  # kg
    inertia: Annotated[Floats, "n"]  # kg m^2; 1 for a point mass, whose third slot stays at rest
    scene_index: Annotated[Ints, "n"]  # place in the scene's order
    q: Annotated[Ints, "n"]  # first place in the state of Rx, Ry, theta
    v: Annotated[Ints, "n"]  # first place in the state of their rates
    parent: Annotated[Ints, "n"]  # n for ground or none


class Slots(NamedTuple):
    body: Annotated[Ints, "n_slots", 2]  # sides 0 and 1
    padding: Annotated[Floats, "n_slots", 3]  # : 1 where a row is unused, else 0


class PairJoints(NamedTuple):
    """Revolute, prismatic, weld and distance joints all fill this group; each type has its own."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]  # first row in the slot
    side_a: Annotated[Ints, "k"]  # which side of the slot is body_a
    point_a: Annotated[Floats, "k", 2]  # m, in body a
    point_b: Annotated[Floats, "k", 2]  # m, in body b
    normal: Annotated[Floats, "k", 2]  # prismatic: unit normal of the axis, in body a
    value: Annotated[Floats, "k"]  # relative angle (rad) or length (m) to keep


class Drives(NamedTuple):
    """One prescribed row: direction . (r_body - start) + turn (theta - start) = signal."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side: Annotated[Ints, "k"]  # which side of the slot is the body
    point: Annotated[Floats, "k", 2]  # m, in the body
    direction: Annotated[Floats, "k", 2]  # unit vector, or zero for an angle drive
    turn: Annotated[Floats, "k"]  # 1 for an angle drive, else 0
    start: Annotated[Floats, "k"]  # value of the driven coordinate at t = 0
    signal: Annotated[Ints, "k"]


class Forces(NamedTuple):
    body: Annotated[Ints, "k"]
    point: Annotated[Floats, "k", 2]  # m, in the body
    vector: Annotated[Floats, "k", 2]  # N
    follows: Annotated[Ints, "k"]  # 1 along body axes
    torque: Annotated[Floats, "k"]  # N m
    signal: Annotated[Ints, "k"]


class TorsionSprings(NamedTuple):
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    stiffness: Annotated[Floats, "k"]  # N m/rad
    damping: Annotated[Floats, "k"]  # N m s/rad
    rest_angle: Annotated[Floats, "k"]  # rad


class ContactPairs(NamedTuple):
    """Shapes that may touch; see PAIR_* for the kinds and mbs_ref.scene.contact for the meaning."""

    kind: Annotated[Ints, "k"]  # PAIR_*
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    center: Annotated[Floats, "k", 2]  # m, the circle's centre in body a
    radius: Annotated[Floats, "k"]  # m, of the circle; clearance of a pin
    origin: Annotated[Floats, "k", 2]  # m, in body b: middle of the line, centre of the other circle, axle
    direction: Annotated[Floats, "k", 2]  # in body b: unit vector along the line, or towards the first seat
    half: Annotated[Floats, "k"]  # m: half length of a segment, inf for a line; other circle's radius; pitch radius
    ends: Annotated[Ints, "k"]  # ENDS_*; number of teeth
    thickness: Annotated[Floats, "k"]  # m, inf where unlimited; reach of the teeth beyond the pitch circle
    flank: Annotated[Floats, "k", 2]  # cosine and sine of a flank's angle


class PlanarGroups(NamedTuple):
    """Every array of a compiled planar scene."""

    bodies: Bodies
    slots: Slots
    loops: Loops
    revolute: PairJoints
    prismatic: PairJoints
    weld: PairJoints
    distance: PairJoints
    drives: Drives
    forces: Forces
    springs: Springs
    torsion_springs: TorsionSprings
    contact_pairs: ContactPairs
    contact_laws: ContactLaws
    contact_modes: ContactModes
    near_pairs: NearPairs
    watches: Watches
    signals: SignalArrays
    world: World


revolute_of = accessor("revolute")
prismatic_of = accessor("prismatic")
weld_of = accessor("weld")
distance_of = accessor("distance")


class Kinematics(NamedTuple):
    """Last row: ground."""

    pose: Annotated[Floats, "n + 1", 4]  # x, y, cos, sin
    motion: Annotated[Floats, "n + 1", 4]  # vx, vy, omega, theta
    force: Annotated[Floats, "n + 1", 3]  # N, N, N m
    user: Annotated[Floats, 3, "n", 3]  # q, v and f in scene order, for a user's force law


class Tree(NamedTuple):
    articulated: Annotated[Floats, "n + 1", 3, 3]  # lower triangle used
    mass_factor: Annotated[Floats, "n", 6]  # L D L^T of the articulated block
    row_factor: Annotated[Floats, "n", 6]  # L D L^T of J M^-1 J^T
    lift: Annotated[Floats, "n", 3, 3]  # M^-1 J^T
    transfer: Annotated[Floats, "n", 3, 3]  # (J M^-1 J^T)^-1 K
    free: Annotated[Floats, "n", 3]  # M^-1 f of the pass under way
    load: Annotated[Floats, "n + 1", 3]  # f accumulated
    acceleration: Annotated[Floats, "n + 1", 3]  # the solution of the pass, ground row zero


class PlanarScratch(NamedTuple):
    """Scratch of one run."""

    kinematics: Kinematics
    rows: Rows
    tree: Tree
    closures: Closures
    solved: Solved
