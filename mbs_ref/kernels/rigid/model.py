"""The groups of arrays that planar and spatial scenes share, and access to those that both have by one name.

`dimension` is 2 or 3, `rates` those of a body, 3 or 6. Bodies are numbered in elimination order: a parent before its
children, ground last (index n_bodies). Constraint rows lie in slots of up to `rates` rows: slot i < n_bodies joins body
i to its parent in the spanning tree, later slots close loops. A slot has two Jacobian blocks, of its sides 0 and 1; in
a tree slot side 0 is the child. `mbs_ref.cores.loops` tells how the arrays of loop closures come about.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from mbs_ref.kernels.algebra.lanes import WIDTH
from mbs_ref.kernels.border.groups import Floats, Ints, empty, members
from mbs_ref.kernels.contact.laws import ContactLaws, ContactModes
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.contact.neighbours import Granules
from mbs_ref.kernels.jit import jit
from mbs_ref.kernels.signals import SignalArrays


class Loops(NamedTuple):
    """Closures in their order of elimination; the last ones close on ground.

    A path leads from a closure's body to its apex, the apex left out: the closest common ancestor of both bodies. The
    rows have a place in `Closures.passed` at every body of their paths, and at the apex.
    """

    slot: Annotated[Ints, "n_closures"]
    count: Annotated[Ints, "n_closures"]  # rows
    most: Annotated[Ints, "n_closures"]  # of them that can be independent of each other and of those before
    place: Annotated[Ints, "n_closures + 1"]  # first of its places
    start: Annotated[Ints, "n_closures", 2]  # place of each side's rows, -1 for ground
    summit: Annotated[Ints, "n_closures"]  # place at the apex, -1 for ground
    first: Annotated[Ints, "n_closures + 1"]  # in `met`, of the later ones that it meets: by a shared body or by fill
    met: Annotated[Ints, "n_met"]  # the closure that is met, in rising order
    above: Annotated[Ints, "n_met"]  # place of the met one at this one's apex, -1 for ground
    closed: Annotated[Ints, "n + 1", 2]  # closures whose apex a body is: from, up to
    entry: Annotated[Ints, "n + 1"]  # first of the paths through a body
    passing: Annotated[Ints, "n_entries"]  # closure of a path through a body, in rising order
    here: Annotated[Ints, "n_entries"]  # its place at the body
    next: Annotated[Ints, "n_entries"]  # and at the body's parent, -1 for ground


class Closures(NamedTuple):
    """Scratch; `rates` is 3 in the plane and 6 in space, of a body and as many rows as a closure can have."""

    passed: Annotated[Floats, "n_places", "rates", "rates"]  # P^T, the rows as they reach a body, one a column
    column: Annotated[Floats, "n_places", "rates", "rates"]  # B P^T: the body's answer to each, its parent at rest
    joint: Annotated[Floats, "n_places", "rates", "rates"]  # multipliers of the body's joint in that answer
    own: Annotated[Floats, "n_closures", "rates", "rates"]  # D of a closure's rows, then its factors
    coupling: Annotated[Floats, "n_met", "rates", "rates"]  # D of its rows with those of one that it meets
    inverse: Annotated[Floats, "n_closures", "rates"]  # of the pivots
    order: Annotated[Ints, "n_closures", "rates"]  # row behind each pivot
    scale: Annotated[Floats, "n_closures", "rates"]  # mobility of each row without joints
    rhs: Annotated[Floats, "n_closures", "rates"]
    mu: Annotated[Floats, "n_closures", "rates"]
    empty: Annotated[Ints, "n_closures"]  # 1 for an open contact, whose row is empty
    # `Loops.passing` and `Loops.met` without the empty ones: which places of them, body by body and closure by closure
    entry: Annotated[Ints, "n + 1"]
    passing: Annotated[Ints, "n_entries"]
    first: Annotated[Ints, "n_closures + 1"]
    met: Annotated[Ints, "n_met"]
    rank: Annotated[Ints, "n_closures"]  # pivots of each
    regularity: Annotated[Floats, 1]  # smallest accepted pivot, relative; 1 far from any singular pose


def closure_scratch(loops: Loops, rates: int) -> Closures:
    """Allocate the scratch of these closures."""
    n_entries, n_met = len(loops.passing), len(loops.met)
    lengths = {"n_closures": len(loops.slot), "n_places": int(loops.place[-1]), "n_met": n_met}
    every = {"entry": loops.entry.copy(), "passing": np.arange(n_entries), "first": loops.first.copy()}
    return empty(Closures, **lengths, rates=rates)._replace(regularity=np.ones(1), met=np.arange(n_met), **every)


CONTROL_MODE_TIME = 0  # s, a time inside the current step: picks the signals' segments
CONTROL_VELOCITY_GAIN = 1  # 1/s, Baumgarte 2 g
CONTROL_POSITION_GAIN = 2  # 1/s^2, Baumgarte g^2

WATCH_DISTANCE, WATCH_COORDINATE, WATCH_RATE = range(3)


class Bodies(NamedTuple):
    mass: Annotated[Floats, "n"]  # kg
    # kg m^2, 1 for a point mass, which nothing turns; in space body axes: xx, yy, zz, xy, xz, yz
    inertia: Annotated[Floats, "n", "moments"]
    rigid: Annotated[Ints, "n"]  # 0 for a point mass
    alone: Annotated[Ints, "n"]  # 1 where no constraint row touches the body
    scene_index: Annotated[Ints, "n"]  # place in the scene's order
    q: Annotated[Ints, "n"]  # first place in the state of R, and theta or theta0..theta3
    v: Annotated[Ints, "n"]  # first place in the state of their rates; in space omega, body axes
    start: Annotated[Ints, 1]  # entries of the state that are positions and orientations; rates follow
    parent: Annotated[Ints, "n"]  # n for ground or none


class Slots(NamedTuple):
    body: Annotated[Ints, "n_slots", 2]  # sides 0 and 1
    count: Annotated[Ints, "n_slots"]  # rows in use


class Points(NamedTuple):
    """r_b - r_a = 0: a row along each world axis."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]  # first row in the slot
    side_a: Annotated[Ints, "k"]  # which side of the slot is body_a
    point_a: Annotated[Floats, "k", "dimension"]  # m, in body a
    point_b: Annotated[Floats, "k", "dimension"]  # m, in body b


class Planes(NamedTuple):
    """n . (r_b - r_a) = 0 with n fixed in body a: one row; in the plane a line."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side_a: Annotated[Ints, "k"]
    point_a: Annotated[Floats, "k", "dimension"]  # m, in body a
    point_b: Annotated[Floats, "k", "dimension"]  # m, in body b
    normal: Annotated[Floats, "k", "dimension"]  # unit vector, in body a


class Distances(NamedTuple):
    """|r_b - r_a| = length: one row."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side_a: Annotated[Ints, "k"]
    point_a: Annotated[Floats, "k", "dimension"]  # m, in body a
    point_b: Annotated[Floats, "k", "dimension"]  # m, in body b
    length: Annotated[Floats, "k"]  # m


class Drives(NamedTuple):
    """direction . (r - start) = signal: one row, the other side is ground."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side: Annotated[Ints, "k"]  # which side of the slot is the body
    point: Annotated[Floats, "k", "dimension"]  # m, in the body
    direction: Annotated[Floats, "k", "dimension"]  # unit vector, world
    start: Annotated[Floats, "k"]  # m
    signal: Annotated[Ints, "k"]


class Forces(NamedTuple):
    body: Annotated[Ints, "k"]
    point: Annotated[Floats, "k", "dimension"]  # m, in the body
    force: Annotated[Floats, "k", "dimension"]  # N
    torque: Annotated[Floats, "k", "turns"]  # N m
    follows: Annotated[Ints, "k"]  # 1 along body axes
    signal: Annotated[Ints, "k"]


class Springs(NamedTuple):
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    point_a: Annotated[Floats, "k", "dimension"]  # m, in body a
    point_b: Annotated[Floats, "k", "dimension"]  # m, in body b
    stiffness: Annotated[Floats, "k"]  # N/m
    damping: Annotated[Floats, "k"]  # N s/m
    rest_length: Annotated[Floats, "k"]  # m
    limit: Annotated[Floats, "k"]  # N; infinite without one
    isotropic: Annotated[Ints, "k"]  # 1 for a bushing in the plane, whose force follows the gap as a vector
    place: Annotated[Ints, "k"]  # of a tension-only spring's mode in ContactModes; -1 for others


class TorsionSprings(NamedTuple):
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    stiffness: Annotated[Floats, "k"]  # N m/rad
    damping: Annotated[Floats, "k"]  # N m s/rad
    rest_angle: Annotated[Floats, "k"]  # rad
    # in space, with no columns in the plane: where in body a the mark of b is at angle 0, and after a quarter turn
    zero: Annotated[Floats, "k", "axes"]
    quarter: Annotated[Floats, "k", "axes"]
    mark: Annotated[Floats, "k", "axes"]  # in body b


class ContactPairs(NamedTuple):
    """Shapes that may touch; see PAIR_* for the kinds and mbs_ref.scene.contact for the meaning."""

    kind: Annotated[Ints, "k"]  # PAIR_*
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    center: Annotated[Floats, "k", "dimension"]  # m, of the circle or sphere, in body a
    radius: Annotated[Floats, "k"]  # m, of the circle or sphere; clearance of a pin
    origin: Annotated[Floats, "k", "dimension"]  # m, in body b: middle of a flat shape, centre of the other one, axle
    # in body b, unit rows: edges of a flat shape and its normal; the first row of a sprocket points to its first seat
    axes: Annotated[Floats, "k", "dimension", "dimension"]
    half: Annotated[Floats, "k", 2]  # m: half sides, inf where endless; the other one's radius; pitch radius
    ends: Annotated[Ints, "k"]  # ENDS_*; number of teeth
    thickness: Annotated[Floats, "k"]  # m, inf where unlimited; reach of the teeth beyond the pitch circle
    flank: Annotated[Floats, "k", 2]  # cosine and sine of the angle of a tooth's flank
    deflection: Annotated[Ints, "k"]  # place of its two sticking deflections (m) in a spatial state, else -1
    sticking: Annotated[Ints, 1]  # contacts that have such a place


class Watches(NamedTuple):
    """Declared events: a coordinate, a distance or a coordinate's rate crosses a value."""

    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]  # the other body of a distance
    point_a: Annotated[Floats, "k", "dimension"]  # m, in body a
    point_b: Annotated[Floats, "k", "dimension"]  # m, in body b
    quantity: Annotated[Ints, "k"]  # WATCH_*
    component: Annotated[Ints, "k"]  # 0 x, 1 y, 2 angle in the plane and z in space
    value: Annotated[Floats, "k"]  # m, rad, m/s or rad/s
    noise: Annotated[Floats, "k"]  # the same: how far past its value a quantity must be
    direction: Annotated[Ints, "k"]  # 1 rising, -1 falling, 0 either
    stops: Annotated[Ints, "k"]  # 1 where the run ends


class World(NamedTuple):
    gravity: Annotated[Floats, "dimension"]  # m/s^2
    user_force: Annotated[Ints, 1]  # address of a C callback, or 0
    user_rows: Annotated[Ints, 1]  # the same, for constraints of the user's own
    control: Annotated[Floats, 3]  # CONTROL_*


class Rows(NamedTuple):
    jacobian: Annotated[Floats, "n_slots", 2, "rates", "rates"]
    residual: Annotated[Floats, "n_slots", "rates"]  # C
    rate: Annotated[Floats, "n_slots", "rates"]  # C_dot
    gamma: Annotated[Floats, "n_slots", "rates"]  # right-hand side of C_q qdd = Q_d
    multiplier: Annotated[Floats, "n_slots", "rates"]


class Tree(NamedTuple):
    """Blocks of the elimination along the tree; factors are L D L^T with 1 / D on the diagonal."""

    articulated: Annotated[Floats, "n + 1", "rates", "rates"]  # lower triangle, factored in place
    row_factor: Annotated[Floats, "n", "rates", "rates"]  # of J M^-1 J^T
    lift: Annotated[Floats, "n", "rates", "rates"]  # M^-1 J^T; in space row r is that of joint row r
    transfer: Annotated[Floats, "n", "rates", "rates"]  # (J M^-1 J^T)^-1 K
    free: Annotated[Floats, "n", "rates"]  # M^-1 f of the pass under way
    load: Annotated[Floats, "n + 1", "rates"]  # f accumulated
    acceleration: Annotated[Floats, "n + 1", "rates"]  # the solution of the pass, ground row zero


class Before(NamedTuple):
    """A solution that is refined, and no forces."""

    acceleration: Annotated[Floats, "n + 1", "rates"]
    multiplier: Annotated[Floats, "n_slots", "rates"]
    gamma: Annotated[Floats, "n_slots", "rates"]
    nothing: Annotated[Floats, "n + 1", "rates"]


class Beside(NamedTuple):
    """The systems of the runs in lanes, which evaluate loads that depend on modes of their own."""

    model: Annotated[Ints, WIDTH]  # addresses of their handles
    work: Annotated[Ints, WIDTH]
    always: Annotated[Ints, 1]  # 1 where loads do not depend on modes alone


class Solved(NamedTuple):
    """Which state the accelerations in the tree belong to."""

    time: Annotated[Floats, 1]  # s; NaN where they may be another state's
    state: Annotated[Floats, "n_state"]


GROUPS: dict[str, type] = {  # of every scene of bodies and joints
    "bodies": Bodies, "slots": Slots, "loops": Loops, "points": Points, "planes": Planes, "distances": Distances,
    "drives": Drives, "forces": Forces, "springs": Springs, "torsion_springs": TorsionSprings,
    "contact_pairs": ContactPairs, "contact_laws": ContactLaws, "contact_modes": ContactModes,
    "near_pairs": NearPairs, "granules": Granules, "watches": Watches, "signals": SignalArrays, "world": World,
}  # fmt: skip
SCRATCH: dict[str, type] = {
    "rows": Rows, "tree": Tree, "closures": Closures, "solved": Solved, "before": Before, "beside": Beside,
}  # fmt: skip


def rigid_scratch(scratch: type, n: int, n_slots: int, n_state: int, loops: Loops, **lengths: int) -> Any:
    """Return the scratch of one run, zero but for the pivots of `loops` and no state solved."""
    own = {"n": n, "n + 1": n + 1, "n_slots": n_slots, "n_state": n_state, **lengths}
    groups = {name: empty(kind, **own) for name, kind in members(scratch).items() if name != "closures"}
    groups["solved"].time[0] = np.nan
    return scratch(closures=closure_scratch(loops, lengths["rates"]), **groups)


rigid_position_count = jit(lambda model: model.bodies.start[0])
