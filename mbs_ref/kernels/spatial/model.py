"""The arrays of a compiled spatial scene, one homogeneous group per element type.

Bodies are numbered in elimination order: a parent before its children, ground last (index n_bodies).
A rigid body has the coordinates R and theta0..theta3 and the rates R', omega; a point mass has R and R'
alone. Joints are broken up into five element types: shared points, products of directions, points on
planes, distances and prescribed turns. Rows live in slots of up to six: slot i < n_bodies joins body i to
its parent in the spanning tree, later slots close loops; in a tree slot side 0 is the child.
"""

# Groups are filled from lists of arrays whose length the checker cannot see.
# pyright: reportCallIssue=false

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbs_ref.kernels.border.handles import accessor
from mbs_ref.kernels.contact.laws import ContactLaws, ContactModes, fresh_modes, no_laws
from mbs_ref.kernels.contact.near_pairs import NearPairs, no_pairs
from mbs_ref.kernels.signals import SignalArrays


class Bodies(NamedTuple):
    mass: np.ndarray  # (n,) kg
    inertia: np.ndarray  # (n, 6) kg m^2, body axes: xx, yy, zz, xy, xz, yz; 1, 1, 1, 0, 0, 0 for a point mass
    rigid: np.ndarray  # (n,) int: 0 for a point mass
    alone: np.ndarray  # (n,) int: 1 where no joint row touches the body
    scene_index: np.ndarray  # (n,) int, place in the scene's order
    q: np.ndarray  # (n,) int, first place in the state of R, theta
    v: np.ndarray  # (n,) int, first place in the state of R', omega (body axes)
    parent: np.ndarray  # (n,) int, n for ground or none


class Slots(NamedTuple):
    body: np.ndarray  # (n_slots, 2) int: sides 0 and 1
    count: np.ndarray  # (n_slots,) int: rows in use
    closure_slot: np.ndarray  # (n_rows,) int: the loop-closure rows, slot ...
    closure_row: np.ndarray  # (n_rows,) int: ... and row in it
    closure_rank: np.ndarray  # (1,) int: the most of them that are independent in any pose of the mechanism


class Points(NamedTuple):
    """r_b - r_a = 0: three rows along the world axes."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int, first row in the slot
    side_a: np.ndarray  # (k,) int, which side of the slot is body_a
    point_a: np.ndarray  # (k, 3) m, in body a
    point_b: np.ndarray  # (k, 3) m, in body b


class Products(NamedTuple):
    """e_a . e_b = 0 of two directions that are to stay perpendicular: one row."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int
    side_a: np.ndarray  # (k,) int
    along_a: np.ndarray  # (k, 3) unit vector, in body a
    along_b: np.ndarray  # (k, 3) unit vector, in body b
    value: np.ndarray  # (k,) the product to keep


class Planes(NamedTuple):
    """n . (r_b - r_a) = 0 with n fixed in body a: one row."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int
    side_a: np.ndarray  # (k,) int
    point_a: np.ndarray  # (k, 3) m, in body a
    point_b: np.ndarray  # (k, 3) m, in body b
    normal: np.ndarray  # (k, 3) unit vector, in body a


class Distances(NamedTuple):
    """|r_b - r_a| = length: one row."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int
    side_a: np.ndarray  # (k,) int
    point_a: np.ndarray  # (k, 3) m, in body a
    point_b: np.ndarray  # (k, 3) m, in body b
    length: np.ndarray  # (k,) m


class Turns(NamedTuple):
    """sin(angle about an axis of a - signal) = 0: one row."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int
    side_a: np.ndarray  # (k,) int
    zero: np.ndarray  # (k, 3) in body a: where the mark of b is at angle 0 ...
    quarter: np.ndarray  # (k, 3) in body a: ... and after a quarter turn
    mark: np.ndarray  # (k, 3) in body b
    signal: np.ndarray  # (k,) int


class Drives(NamedTuple):
    """direction . (r - start) = signal: one row, the other side is ground."""

    slot: np.ndarray  # (k,) int
    row: np.ndarray  # (k,) int
    side: np.ndarray  # (k,) int, which side of the slot is the body
    point: np.ndarray  # (k, 3) m, in the body
    direction: np.ndarray  # (k, 3) unit vector, world
    start: np.ndarray  # (k,) m
    signal: np.ndarray  # (k,) int


class Forces(NamedTuple):
    body: np.ndarray  # (k,) int
    point: np.ndarray  # (k, 3) m, in the body
    force: np.ndarray  # (k, 3) N
    torque: np.ndarray  # (k, 3) N m
    follows: np.ndarray  # (k,) int: 1 along body axes
    signal: np.ndarray  # (k,) int


class Springs(NamedTuple):
    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int
    point_a: np.ndarray  # (k, 3) m, in body a
    point_b: np.ndarray  # (k, 3) m, in body b
    stiffness: np.ndarray  # (k,) N/m
    damping: np.ndarray  # (k,) N s/m
    rest_length: np.ndarray  # (k,) m
    tension_only: np.ndarray  # (k,) int


class TorsionSprings(NamedTuple):
    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int
    zero: np.ndarray  # (k, 3) in body a: where the mark of b is at angle 0 ...
    quarter: np.ndarray  # (k, 3) in body a: ... and after a quarter turn
    mark: np.ndarray  # (k, 3) in body b
    stiffness: np.ndarray  # (k,) N m/rad
    damping: np.ndarray  # (k,) N m s/rad
    rest_angle: np.ndarray  # (k,) rad


class Bushings(NamedTuple):
    """Six-axis springs; `axes` turn bushing axes into body axes."""

    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int
    point_a: np.ndarray  # (k, 3) m, in body a
    point_b: np.ndarray  # (k, 3) m, in body b
    axes_a: np.ndarray  # (k, 3, 3)
    axes_b: np.ndarray  # (k, 3, 3)
    stiffness: np.ndarray  # (k, 6) N/m and N m/rad
    damping: np.ndarray  # (k, 6) N s/m and N m s/rad


class ContactPairs(NamedTuple):
    """Shapes that may touch; see PAIR_* for the kinds and mbs_ref.scene.contact for the meaning."""

    kind: np.ndarray  # (k,) int, PAIR_*
    a: np.ndarray  # (k,) int
    b: np.ndarray  # (k,) int
    center: np.ndarray  # (k, 3) m, the sphere's centre in body a
    radius: np.ndarray  # (k,) m, of the sphere
    origin: np.ndarray  # (k, 3) m, in body b: on the plane, or centre of the other sphere
    axes: np.ndarray  # (k, 3, 3) in body b, unit rows: two edges of the plane and its normal
    half: np.ndarray  # (k, 2) m: half sides of a rectangle, inf for a plane; other sphere's radius
    ends: np.ndarray  # (k,) int, ENDS_*
    thickness: np.ndarray  # (k,) m, inf where unlimited
    deflection: np.ndarray  # (k,) int, place of its two sticking deflections (m) in the state, -1 where there are none
    sticking: np.ndarray  # (1,) int, contacts that can stick


PAIR_PLANE, PAIR_SPHERE = range(2)


class Attraction(NamedTuple):
    """Newton's gravity between all pairs of centres of mass."""

    gm: np.ndarray  # (n,) m^3/s^2; empty where bodies do not attract each other


class World(NamedTuple):
    gravity: np.ndarray  # (3,) m/s^2
    user_force: np.ndarray  # (1,) int: address of a C callback, or 0
    control: np.ndarray  # (3,) see kernels/controls.py


class SpatialGroups(NamedTuple):
    """Every array of a compiled spatial scene."""

    bodies: Bodies
    slots: Slots
    points: Points
    products: Products
    planes: Planes
    distances: Distances
    turns: Turns
    drives: Drives
    forces: Forces
    springs: Springs
    torsion_springs: TorsionSprings
    bushings: Bushings
    contact_pairs: ContactPairs
    contact_laws: ContactLaws
    contact_modes: ContactModes
    near_pairs: NearPairs
    attraction: Attraction
    signals: SignalArrays
    world: World


def _floats(*shape: int) -> np.ndarray:
    return np.zeros(shape)


def _integers(*shape: int) -> np.ndarray:
    return np.zeros(shape, dtype=np.int64)


def _i(count: int) -> list[np.ndarray]:
    return [_integers(0) for _ in range(count)]


def _vectors(count: int) -> list[np.ndarray]:
    return [_floats(0, 3) for _ in range(count)]


_EMPTY = SpatialGroups(
    bodies=Bodies(_floats(0), _floats(0, 6), *_i(6)),
    slots=Slots(_integers(0, 2), *_i(4)),
    points=Points(*_i(3), *_vectors(2)),
    products=Products(*_i(3), *_vectors(2), _floats(0)),
    planes=Planes(*_i(3), *_vectors(3)),
    distances=Distances(*_i(3), *_vectors(2), _floats(0)),
    turns=Turns(*_i(3), *_vectors(3), _integers(0)),
    drives=Drives(*_i(3), *_vectors(2), _floats(0), _integers(0)),
    forces=Forces(_integers(0), *_vectors(3), *_i(2)),
    springs=Springs(*_i(2), *_vectors(2), _floats(0), _floats(0), _floats(0), _integers(0)),
    torsion_springs=TorsionSprings(*_i(2), *_vectors(3), _floats(0), _floats(0), _floats(0)),
    bushings=Bushings(*_i(2), *_vectors(2), _floats(0, 3, 3), _floats(0, 3, 3), _floats(0, 6), _floats(0, 6)),
    contact_pairs=ContactPairs(
        *_i(3), _floats(0, 3), _floats(0), _floats(0, 3), _floats(0, 3, 3), _floats(0, 2), _integers(0), _floats(0),
        _integers(0), _integers(1),
    ),
    contact_laws=no_laws(),
    contact_modes=fresh_modes(0, 0.0, 0, 2),
    near_pairs=no_pairs(3),
    attraction=Attraction(_floats(0)),
    signals=SignalArrays(_integers(0), _floats(0), _floats(0, 1), _floats(0), _floats(0), _floats(0)),
    world=World(_floats(3), _integers(1), _floats(3)),
)
bodies_of = accessor(_EMPTY, "bodies")
slots_of = accessor(_EMPTY, "slots")
points_of = accessor(_EMPTY, "points")
products_of = accessor(_EMPTY, "products")
planes_of = accessor(_EMPTY, "planes")
distances_of = accessor(_EMPTY, "distances")
turns_of = accessor(_EMPTY, "turns")
drives_of = accessor(_EMPTY, "drives")
forces_of = accessor(_EMPTY, "forces")
springs_of = accessor(_EMPTY, "springs")
torsion_springs_of = accessor(_EMPTY, "torsion_springs")
bushings_of = accessor(_EMPTY, "bushings")
contact_pairs_of = accessor(_EMPTY, "contact_pairs")
contact_laws_of = accessor(_EMPTY, "contact_laws")
contact_modes_of = accessor(_EMPTY, "contact_modes")
near_pairs_of = accessor(_EMPTY, "near_pairs")
attraction_of = accessor(_EMPTY, "attraction")
signals_of = accessor(_EMPTY, "signals")
world_of = accessor(_EMPTY, "world")


class Kinematics(NamedTuple):
    """Last row: ground."""

    position: np.ndarray  # (n + 1, 3) m
    turned: np.ndarray  # (n + 1, 3, 3) A(theta / |theta|)
    theta: np.ndarray  # (n + 1, 4) Euler parameters as the state has them
    norm: np.ndarray  # (n + 1,) theta . theta - 1
    velocity: np.ndarray  # (n + 1, 3) m/s
    omega: np.ndarray  # (n + 1, 3) rad/s, world
    inertia: np.ndarray  # (n + 1, 6) world axes: xx, yy, zz, xy, xz, yz
    force: np.ndarray  # (n + 1, 6) N; N m about the centre of mass
    user: np.ndarray  # (3, n, 7) q, v and f in scene order, for a user's force law


class Rows(NamedTuple):
    jacobian: np.ndarray  # (n_slots, 2, 6, 6) of (R', omega)
    residual: np.ndarray  # (n_slots, 6) C
    rate: np.ndarray  # (n_slots, 6) C_dot
    gamma: np.ndarray  # (n_slots, 6) right-hand side of C_q qdd = Q_d
    multiplier: np.ndarray  # (n_slots, 6)


class Tree(NamedTuple):
    articulated: np.ndarray  # (n + 1, 6, 6) lower triangle, factored in place
    row_factor: np.ndarray  # (n, 6, 6) L D L^T of J M^-1 J^T
    lift: np.ndarray  # (n, 6, 6) row r: M^-1 J^T of joint row r
    transfer: np.ndarray  # (n, 6, 6) (J M^-1 J^T)^-1 K
    free: np.ndarray  # (n, 6) M^-1 f of the pass under way
    load: np.ndarray  # (n + 1, 6) f accumulated
    acceleration: np.ndarray  # (n + 1, 6) the solution of the pass, ground row zero


class Closures(NamedTuple):
    columns: np.ndarray  # (n_rows, n + 1, 6) response to a unit multiplier of each closure row
    column_multiplier: np.ndarray  # (n_rows, n, 6) tree multipliers of that response
    schur: np.ndarray  # (n_rows, n_rows)
    scale: np.ndarray  # (n_rows,)
    lower: np.ndarray  # (n_rows, n_rows)
    gram: np.ndarray  # (n_rows, n_rows)
    order: np.ndarray  # (n_rows,) int
    rhs: np.ndarray  # (n_rows,)
    mu: np.ndarray  # (n_rows,)
    rank: np.ndarray  # (1,) int, rank of the closure rows at the last factorization
    regularity: np.ndarray  # (1,) smallest accepted closure pivot, relative; 1 far from any singular pose


class Grips(NamedTuple):
    deflection: np.ndarray  # (n_sticking, 2) m, of the springs of sticking contacts along the plane's edges


class SpatialScratch(NamedTuple):
    """Scratch of one run."""

    kinematics: Kinematics
    rows: Rows
    tree: Tree
    closures: Closures
    grips: Grips


def spatial_scratch(n: int, n_slots: int, n_rows: int, n_sticking: int = 0) -> SpatialScratch:
    """Allocate the scratch of one run."""
    turned = np.tile(np.eye(3), (n + 1, 1, 1))
    vectors = [_floats(n + 1, 3) for _ in range(3)]
    slot = [_floats(n_slots, 6) for _ in range(4)]
    square = [_floats(n_rows, n_rows) for _ in range(3)]
    line = [_floats(n_rows) for _ in range(3)]
    return SpatialScratch(
        kinematics=Kinematics(
            vectors[0], turned, _floats(n + 1, 4), _floats(n + 1), vectors[1], vectors[2],
            _floats(n + 1, 6), _floats(n + 1, 6), _floats(3, n, 7),
        ),
        rows=Rows(_floats(n_slots, 2, 6, 6), *slot),
        tree=Tree(
            _floats(n + 1, 6, 6), _floats(n, 6, 6), _floats(n, 6, 6), _floats(n, 6, 6),
            _floats(n, 6), _floats(n + 1, 6), _floats(n + 1, 6),
        ),
        closures=Closures(
            columns=_floats(n_rows, n + 1, 6),
            column_multiplier=_floats(n_rows, n, 6),
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
        grips=Grips(_floats(n_sticking, 2)),
    )  # fmt: skip


_NO_SCRATCH = spatial_scratch(0, 0, 0)
kinematics_of = accessor(_NO_SCRATCH, "kinematics")
rows_of = accessor(_NO_SCRATCH, "rows")
tree_of = accessor(_NO_SCRATCH, "tree")
closures_of = accessor(_NO_SCRATCH, "closures")
grips_of = accessor(_NO_SCRATCH, "grips")
