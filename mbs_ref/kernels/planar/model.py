"""The arrays of a compiled planar scene, one homogeneous group per element type.

Bodies are numbered in elimination order: a parent before its children, ground last (index n_bodies).
Constraint rows live in slots of up to three rows: slot i < n_bodies joins body i to its parent in the
spanning tree, later slots close loops. A slot holds two 3x3 Jacobian blocks, side 0 and side 1; in a
tree slot side 0 is the child.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import accessor
from mbs_ref.kernels.contact.laws import ContactLaws, ContactModes
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.rigid.closures import Closures, Loops, closure_scratch
from mbs_ref.kernels.signals import SignalArrays

RATES = tuple(range(3))  # of a body: a loop over it has bounds that the compiler knows


class Bodies(NamedTuple):
    mass: Annotated[Floats, "n"]  # kg
    inertia: Annotated[Floats, "n"]  # kg m^2; 1 for a point mass, whose third slot stays at rest
    scene_index: Annotated[Ints, "n"]  # place in the scene's order and in the state vector
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


class Springs(NamedTuple):
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    point_a: Annotated[Floats, "k", 2]  # m, in body a
    point_b: Annotated[Floats, "k", 2]  # m, in body b
    stiffness: Annotated[Floats, "k"]  # N/m
    damping: Annotated[Floats, "k"]  # N s/m
    rest_length: Annotated[Floats, "k"]  # m
    tension_only: Annotated[Ints, "k"]
    isotropic: Annotated[Ints, "k"]  # 1 for a bushing, whose force follows the gap as a vector
    place: Annotated[Ints, "k"]  # of a tension-only spring's mode in ContactModes; -1 for others


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


class Watches(NamedTuple):
    """Declared events: a coordinate, a distance or a coordinate's rate crosses a value."""

    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]  # the other body of a distance
    point_a: Annotated[Floats, "k", 2]  # m, in body a
    point_b: Annotated[Floats, "k", 2]  # m, in body b
    quantity: Annotated[Ints, "k"]  # WATCH_*: distance, coordinate or rate
    component: Annotated[Ints, "k"]  # 0 x, 1 y, 2 angle
    value: Annotated[Floats, "k"]  # m, rad, m/s or rad/s
    direction: Annotated[Ints, "k"]  # 1 rising, -1 falling, 0 either
    stops: Annotated[Ints, "k"]  # 1 where the run ends


PAIR_LINE, PAIR_CIRCLE, PAIR_SPROCKET = range(3)
WATCH_DISTANCE, WATCH_COORDINATE, WATCH_RATE = range(3)


class World(NamedTuple):
    gravity: Annotated[Floats, 2]  # m/s^2
    user_force: Annotated[Ints, 1]  # address of a C callback, or 0
    user_rows: Annotated[Ints, 1]  # the same, for constraints of the user's own
    control: Annotated[Floats, 3]  # see kernels/controls.py


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


bodies_of = accessor(PlanarGroups, "bodies")
slots_of = accessor(PlanarGroups, "slots")
loops_of = accessor(PlanarGroups, "loops")
revolute_of = accessor(PlanarGroups, "revolute")
prismatic_of = accessor(PlanarGroups, "prismatic")
weld_of = accessor(PlanarGroups, "weld")
distance_of = accessor(PlanarGroups, "distance")
drives_of = accessor(PlanarGroups, "drives")
forces_of = accessor(PlanarGroups, "forces")
springs_of = accessor(PlanarGroups, "springs")
torsion_springs_of = accessor(PlanarGroups, "torsion_springs")
contact_pairs_of = accessor(PlanarGroups, "contact_pairs")
contact_laws_of = accessor(PlanarGroups, "contact_laws")
contact_modes_of = accessor(PlanarGroups, "contact_modes", tangents=1)
near_pairs_of = accessor(PlanarGroups, "near_pairs", dimension=2)
watches_of = accessor(PlanarGroups, "watches")
signals_of = accessor(PlanarGroups, "signals")
world_of = accessor(PlanarGroups, "world")


class Kinematics(NamedTuple):
    """Last row: ground."""

    pose: Annotated[Floats, "n + 1", 4]  # x, y, cos, sin
    motion: Annotated[Floats, "n + 1", 4]  # vx, vy, omega, theta
    force: Annotated[Floats, "n + 1", 3]  # N, N, N m
    user: Annotated[Floats, 3, "n", 3]  # q, v and f in scene order, for a user's force law


class Rows(NamedTuple):
    jacobian: Annotated[Floats, "n_slots", 2, 3, 3]
    residual: Annotated[Floats, "n_slots", 3]  # C
    rate: Annotated[Floats, "n_slots", 3]  # C_dot
    gamma: Annotated[Floats, "n_slots", 3]  # right-hand side of C_q qdd = Q_d
    multiplier: Annotated[Floats, "n_slots", 3]


class Tree(NamedTuple):
    articulated: Annotated[Floats, "n + 1", 3, 3]  # lower triangle used
    mass_factor: Annotated[Floats, "n", 6]  # L D L^T of the articulated block
    row_factor: Annotated[Floats, "n", 6]  # L D L^T of J M^-1 J^T
    lift: Annotated[Floats, "n", 3, 3]  # M^-1 J^T
    transfer: Annotated[Floats, "n", 3, 3]  # (J M^-1 J^T)^-1 K
    free: Annotated[Floats, "n", 3]  # M^-1 f of the pass under way
    load: Annotated[Floats, "n + 1", 3]  # f accumulated
    acceleration: Annotated[Floats, "n + 1", 3]  # the solution of the pass, ground row zero
    holds: Annotated[Floats, 1]  # s, when it is the motion's at the state in the kinematics; NaN where it may not be


class PlanarScratch(NamedTuple):
    """Scratch of one run."""

    kinematics: Kinematics
    rows: Rows
    tree: Tree
    closures: Closures


def _floats(*shape: int) -> np.ndarray:
    return np.zeros(shape)


def planar_scratch(n: int, n_slots: int, loops: Loops) -> PlanarScratch:
    """Allocate the scratch of one run."""
    pose = _floats(n + 1, 4)
    pose[:, 2] = 1.0
    slot = [_floats(n_slots, 3) for _ in range(4)]
    factors = (_floats(n + 1, 3, 3), _floats(n, 6), _floats(n, 6), _floats(n, 3, 3), _floats(n, 3, 3))
    return PlanarScratch(
        kinematics=Kinematics(pose, _floats(n + 1, 4), _floats(n + 1, 3), _floats(3, n, 3)),
        rows=Rows(_floats(n_slots, 2, 3, 3), *slot),
        tree=Tree(*factors, _floats(n, 3), _floats(n + 1, 3), _floats(n + 1, 3), np.full(1, np.nan)),
        closures=closure_scratch(loops, 3),
    )


kinematics_of = accessor(PlanarScratch, "kinematics")
rows_of = accessor(PlanarScratch, "rows")
tree_of = accessor(PlanarScratch, "tree")
closures_of = accessor(PlanarScratch, "closures", rates=3)
