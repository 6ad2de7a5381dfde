"""The arrays of a compiled planar scene, one homogeneous group per element type.

Bodies are numbered in elimination order: a parent before its children, ground last (index n_bodies).
Constraint rows live in slots of up to three rows: slot i < n_bodies joins body i to its parent in the
spanning tree, later slots close loops. A slot holds two 3x3 Jacobian blocks, side 0 and side 1; in a
tree slot side 0 is the child.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.border.handles import accessor
from mbs_ref.kernels.contact.laws import ContactLaws, ContactModes, fresh_modes, no_laws
from mbs_ref.kernels.contact.near_pairs import NearPairs, no_pairs
from mbs_ref.kernels.signals import SignalArrays


class Bodies(NamedTuple):
    mass: np.ndarray  # (n,) kg
    inertia: np.ndarray  # (n,) kg m^2; 1 for a point mass, whose third slot stays at rest
    scene_index: np.ndarray  # (n,) int, place in the scene's order and in the state vector
    parent: np.ndarray  # (n,) int, n for ground or none


class Slots(NamedTuple):
    body: np.ndarray  # (n_slots, 2) int: sides 0 and 1
    padding: np.ndarray  # (n_slots, 3): 1 where a row is unused, else 0
    closure_slot: np.ndarray  # (n_rows,) int: the loop-closure rows, slot ...
    closure_row: np.ndarray  # (n_rows,) int: ... and row in it


class PairJoints(NamedTuple):
    """Revolute, prismatic, weld and distance joints all fill this group; each type has its own."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int, first row in the slot
    side_a: np.ndarray  # (k,) int, which side of the slot is body_a
    point_a: np.ndarray  # (k, 2) m, in body a
    point_b: np.ndarray  # (k, 2) m, in body b
    normal: np.ndarray  # (k, 2) prismatic: unit normal of the axis, in body a
    value: np.ndarray  # (k,) relative angle (rad) or length (m) to keep


class Drives(NamedTuple):
    """One prescribed row: direction . (r_body - start) + turn (theta - start) = signal."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int
    side: np.ndarray  # (k,) int, which side of the slot is the body
    point: np.ndarray  # (k, 2) m, in the body
    direction: np.ndarray  # (k, 2) unit vector, or zero for an angle drive
    turn: np.ndarray  # (k,) 1 for an angle drive, else 0
    start: np.ndarray  # (k,) value of the driven coordinate at t = 0
    signal: np.ndarray  # (k,) int


class Forces(NamedTuple):
    body: np.ndarray  # (k,) int
    point: np.ndarray  # (k, 2) m, in the body
    vector: np.ndarray  # (k, 2) N
    follows: np.ndarray  # (k,) int: 1 along body axes
    torque: np.ndarray  # (k,) N m
    signal: np.ndarray  # (k,) int


class Springs(NamedTuple):
    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int
    point_a: np.ndarray  # (k, 2) m, in body a
    point_b: np.ndarray  # (k, 2) m, in body b
    stiffness: np.ndarray  # (k,) N/m
    damping: np.ndarray  # (k,) N s/m
    rest_length: np.ndarray  # (k,) m
    tension_only: np.ndarray  # (k,) int
    isotropic: np.ndarray  # (k,) int: 1 for a bushing, whose force follows the gap as a vector
    place: np.ndarray  # (k,) int, of a tension-only spring's mode in ContactModes; -1 for others


class TorsionSprings(NamedTuple):
    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int
    stiffness: np.ndarray  # (k,) N m/rad
    damping: np.ndarray  # (k,) N m s/rad
    rest_angle: np.ndarray  # (k,) rad


class ContactPairs(NamedTuple):
    """Shapes that may touch; see PAIR_* for the kinds and mbs_ref.scene.contact for the meaning."""

    kind: np.ndarray  # (k,) int, PAIR_*
    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int
    center: np.ndarray  # (k, 2) m, the circle's centre in body a
    radius: np.ndarray  # (k,) m, of the circle; clearance of a pin
    origin: np.ndarray  # (k, 2) m, in body b: middle of the line, centre of the other circle, axle
    direction: np.ndarray  # (k, 2) in body b: unit vector along the line, or towards the first seat
    half: np.ndarray  # (k,) m: half length of a segment, inf for a line; other circle's radius; pitch radius
    ends: np.ndarray  # (k,) int, ENDS_*; number of teeth
    thickness: np.ndarray  # (k,) m, inf where unlimited; reach of the teeth beyond the pitch circle
    flank: np.ndarray  # (k, 2) cosine and sine of a flank's angle


class Watches(NamedTuple):
    """Declared events: a coordinate, a distance or a coordinate's rate crosses a value."""

    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int, the other body of a distance
    point_a: np.ndarray  # (k, 2) m, in body a
    point_b: np.ndarray  # (k, 2) m, in body b
    quantity: np.ndarray  # (k,) int, WATCH_*: distance, coordinate or rate
    component: np.ndarray  # (k,) int: 0 x, 1 y, 2 angle
    value: np.ndarray  # (k,) m, rad, m/s or rad/s
    direction: np.ndarray  # (k,) int: 1 rising, -1 falling, 0 either
    stops: np.ndarray  # (k,) int: 1 where the run ends


PAIR_LINE, PAIR_CIRCLE, PAIR_SPROCKET = range(3)
WATCH_DISTANCE, WATCH_COORDINATE, WATCH_RATE = range(3)


class World(NamedTuple):
    gravity: np.ndarray  # (2,) m/s^2
    user_force: np.ndarray  # (1,) int: address of a C callback, or 0
    control: np.ndarray  # (3,) see kernels/controls.py


class PlanarGroups(NamedTuple):
    """Every array of a compiled planar scene."""

    bodies: Bodies
    slots: Slots
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


def _floats(*shape: int) -> np.ndarray:
    return np.zeros(shape)


def _integers(*shape: int) -> np.ndarray:
    return np.zeros(shape, dtype=np.int64)


def _no_pair_joints() -> PairJoints:
    integers = (_integers(0), _integers(0), _integers(0))
    return PairJoints(*integers, _floats(0, 2), _floats(0, 2), _floats(0, 2), _floats(0))


def _no_contact_pairs() -> ContactPairs:
    integers, floats, points = _integers(0), _floats(0), _floats(0, 2)
    return ContactPairs(
        integers, integers, integers, points, floats, points, points, floats, integers, floats, points
    )  # fmt: skip


_EMPTY = PlanarGroups(
    bodies=Bodies(_floats(0), _floats(0), _integers(0), _integers(0)),
    slots=Slots(_integers(0, 2), _floats(0, 3), _integers(0), _integers(0)),
    revolute=_no_pair_joints(),
    prismatic=_no_pair_joints(),
    weld=_no_pair_joints(),
    distance=_no_pair_joints(),
    drives=Drives(
        _integers(0), _integers(0), _integers(0), _floats(0, 2), _floats(0, 2), _floats(0), _floats(0), _integers(0)
    ),
    forces=Forces(_integers(0), _floats(0, 2), _floats(0, 2), _integers(0), _floats(0), _integers(0)),
    springs=Springs(
        _integers(0),
        _integers(0),
        _floats(0, 2),
        _floats(0, 2),
        _floats(0),
        _floats(0),
        _floats(0),
        _integers(0),
        _integers(0),
        _integers(0),
    ),
    torsion_springs=TorsionSprings(_integers(0), _integers(0), _floats(0), _floats(0), _floats(0)),
    contact_pairs=_no_contact_pairs(),
    contact_laws=no_laws(),
    contact_modes=fresh_modes(0, 0.0, 0),
    near_pairs=no_pairs(2),
    watches=Watches(
        _integers(0), _integers(0), _floats(0, 2), _floats(0, 2), _integers(0), _integers(0), _floats(0),
        _integers(0), _integers(0),
    ),
    signals=SignalArrays(_integers(0), _floats(0), _floats(0, 1), _floats(0), _floats(0), _floats(0)),
    world=World(_floats(2), _integers(1), _floats(3)),
)
bodies_of = accessor(_EMPTY, "bodies")
slots_of = accessor(_EMPTY, "slots")
revolute_of = accessor(_EMPTY, "revolute")
prismatic_of = accessor(_EMPTY, "prismatic")
weld_of = accessor(_EMPTY, "weld")
distance_of = accessor(_EMPTY, "distance")
drives_of = accessor(_EMPTY, "drives")
forces_of = accessor(_EMPTY, "forces")
springs_of = accessor(_EMPTY, "springs")
torsion_springs_of = accessor(_EMPTY, "torsion_springs")
contact_pairs_of = accessor(_EMPTY, "contact_pairs")
contact_laws_of = accessor(_EMPTY, "contact_laws")
contact_modes_of = accessor(_EMPTY, "contact_modes")
near_pairs_of = accessor(_EMPTY, "near_pairs")
watches_of = accessor(_EMPTY, "watches")
signals_of = accessor(_EMPTY, "signals")
world_of = accessor(_EMPTY, "world")


class Kinematics(NamedTuple):
    """Last row: ground."""

    pose: np.ndarray  # (n + 1, 4) x, y, cos, sin
    motion: np.ndarray  # (n + 1, 4) vx, vy, omega, theta
    force: np.ndarray  # (n + 1, 3) N, N, N m
    user: np.ndarray  # (3, n, 3) q, v and f in scene order, for a user's force law


class Rows(NamedTuple):
    jacobian: np.ndarray  # (n_slots, 2, 3, 3)
    residual: np.ndarray  # (n_slots, 3) C
    rate: np.ndarray  # (n_slots, 3) C_dot
    gamma: np.ndarray  # (n_slots, 3) right-hand side of C_q qdd = Q_d
    multiplier: np.ndarray  # (n_slots, 3)


class Tree(NamedTuple):
    articulated: np.ndarray  # (n + 1, 3, 3) lower triangle used
    mass_factor: np.ndarray  # (n, 6) L D L^T of the articulated block
    row_factor: np.ndarray  # (n, 6) L D L^T of J M^-1 J^T
    lift: np.ndarray  # (n, 3, 3) M^-1 J^T
    transfer: np.ndarray  # (n, 3, 3) (J M^-1 J^T)^-1 K
    free: np.ndarray  # (n, 3) M^-1 f of the pass under way
    load: np.ndarray  # (n + 1, 3) f accumulated
    acceleration: np.ndarray  # (n + 1, 3) the solution of the pass, ground row zero


class Closures(NamedTuple):
    columns: np.ndarray  # (n_rows, n + 1, 3) response to a unit multiplier of each closure row
    column_multiplier: np.ndarray  # (n_rows, n, 3) tree multipliers of that response
    schur: np.ndarray  # (n_rows, n_rows)
    scale: np.ndarray  # (n_rows,)
    lower: np.ndarray  # (n_rows, n_rows)
    gram: np.ndarray  # (n_rows, n_rows)
    order: np.ndarray  # (n_rows,) int
    rhs: np.ndarray  # (n_rows,)
    mu: np.ndarray  # (n_rows,)
    rank: np.ndarray  # (1,) int, rank of the closure rows at the last factorization
    regularity: np.ndarray  # (1,) smallest accepted closure pivot, relative; 1 far from any singular pose


class PlanarScratch(NamedTuple):
    """Scratch of one run."""

    kinematics: Kinematics
    rows: Rows
    tree: Tree
    closures: Closures


def planar_scratch(n: int, n_slots: int, n_rows: int) -> PlanarScratch:
    """Allocate the scratch of one run."""
    pose = _floats(n + 1, 4)
    pose[:, 2] = 1.0
    slot = [_floats(n_slots, 3) for _ in range(4)]
    square = [_floats(n_rows, n_rows) for _ in range(3)]
    line = [_floats(n_rows) for _ in range(3)]
    factors = (_floats(n + 1, 3, 3), _floats(n, 6), _floats(n, 6), _floats(n, 3, 3), _floats(n, 3, 3))
    return PlanarScratch(
        kinematics=Kinematics(pose, _floats(n + 1, 4), _floats(n + 1, 3), _floats(3, n, 3)),
        rows=Rows(_floats(n_slots, 2, 3, 3), *slot),
        tree=Tree(*factors, _floats(n, 3), _floats(n + 1, 3), _floats(n + 1, 3)),
        closures=Closures(
            columns=_floats(n_rows, n + 1, 3),
            column_multiplier=_floats(n_rows, n, 3),
            schur=square[0],
            scale=line[0],
            lower=square[1],
            gram=square[2],
            order=_integers(n_rows),
            rhs=line[1],
            mu=line[2],
            rank=_integers(1),
            regularity=np.ones(1),
        ),
    )


_NO_SCRATCH = planar_scratch(0, 0, 0)
kinematics_of = accessor(_NO_SCRATCH, "kinematics")
rows_of = accessor(_NO_SCRATCH, "rows")
tree_of = accessor(_NO_SCRATCH, "tree")
closures_of = accessor(_NO_SCRATCH, "closures")
