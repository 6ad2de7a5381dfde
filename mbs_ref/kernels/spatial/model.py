"""The arrays of a compiled spatial scene, one homogeneous group per element type.

A rigid body has the coordinates R and theta0..theta3 and the rates R', omega; a point mass has R and R'
alone. Joints are broken up into five element types: shared points, products of directions, points on
planes, distances and prescribed turns. See `rigid.model` for the numbering.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

from mbs_ref.kernels.border.groups import Floats, Ints
from mbs_ref.kernels.border.handles import accessor
from mbs_ref.kernels.contact.laws import ContactLaws, ContactModes
from mbs_ref.kernels.contact.near_pairs import NearPairs
from mbs_ref.kernels.rigid import model as shared
from mbs_ref.kernels.rigid.closures import Closures, Loops
from mbs_ref.kernels.signals import SignalArrays

RATES = tuple(range(6))  # of a body: a loop over it has bounds that the compiler knows


class Bodies(NamedTuple):
    mass: Annotated[Floats, "n"]  # kg
    inertia: Annotated[Floats, "n", 6]  # kg m^2, body axes: xx, yy, zz, xy, xz, yz; 1, 1, 1, 0, 0, 0 for a point mass
    rigid: Annotated[Ints, "n"]  # 0 for a point mass
    alone: Annotated[Ints, "n"]  # 1 where no joint row touches the body
    scene_index: Annotated[Ints, "n"]  # place in the scene's order
    q: Annotated[Ints, "n"]  # first place in the state of R, theta
    v: Annotated[Ints, "n"]  # first place in the state of R', omega (body axes)
    parent: Annotated[Ints, "n"]  # n for ground or none


class Slots(NamedTuple):
    body: Annotated[Ints, "n_slots", 2]  # sides 0 and 1
    count: Annotated[Ints, "n_slots"]  # rows in use


class Products(NamedTuple):
    """e_a . e_b = 0 of two directions that are to stay perpendicular: one row."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side_a: Annotated[Ints, "k"]
    along_a: Annotated[Floats, "k", 3]  # unit vector, in body a
    along_b: Annotated[Floats, "k", 3]  # unit vector, in body b
    value: Annotated[Floats, "k"]  # the product to keep


class Turns(NamedTuple):
    """sin(angle about an axis of a - signal) = 0: one row."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side_a: Annotated[Ints, "k"]
    zero: Annotated[Floats, "k", 3]  # in body a: where the mark of b is at angle 0 ...
    quarter: Annotated[Floats, "k", 3]  # in body a: ... and after a quarter turn
    mark: Annotated[Floats, "k", 3]  # in body b
    signal: Annotated[Ints, "k"]


class Wheels(NamedTuple):
    """The matter at the lowest point of a rim is at rest: three rows, along the plane and its normal."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]  # first row in the slot
    side: Annotated[Ints, "k"]  # which side of the slot is the body
    centre: Annotated[Floats, "k", 3]  # m, in the body
    axis: Annotated[Floats, "k", 3]  # unit vector, in the body
    radius: Annotated[Floats, "k"]  # m
    frame: Annotated[Floats, "k", 3, 3]  # unit rows, world: two edges of the plane and its normal
    height: Annotated[Floats, "k"]  # m, of the plane along its normal


class Forces(NamedTuple):
    body: Annotated[Ints, "k"]
    point: Annotated[Floats, "k", 3]  # m, in the body
    force: Annotated[Floats, "k", 3]  # N
    torque: Annotated[Floats, "k", 3]  # N m
    follows: Annotated[Ints, "k"]  # 1 along body axes
    signal: Annotated[Ints, "k"]


class TorsionSprings(NamedTuple):
    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    zero: Annotated[Floats, "k", 3]  # in body a: where the mark of b is at angle 0 ...
    quarter: Annotated[Floats, "k", 3]  # in body a: ... and after a quarter turn
    mark: Annotated[Floats, "k", 3]  # in body b
    stiffness: Annotated[Floats, "k"]  # N m/rad
    damping: Annotated[Floats, "k"]  # N m s/rad
    rest_angle: Annotated[Floats, "k"]  # rad


class Bushings(NamedTuple):
    """Six-axis springs; `axes` turn bushing axes into body axes."""

    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    point_a: Annotated[Floats, "k", 3]  # m, in body a
    point_b: Annotated[Floats, "k", 3]  # m, in body b
    axes_a: Annotated[Floats, "k", 3, 3]
    axes_b: Annotated[Floats, "k", 3, 3]
    stiffness: Annotated[Floats, "k", 6]  # N/m and N m/rad
    damping: Annotated[Floats, "k", 6]  # N s/m and N m s/rad


class Attraction(NamedTuple):
    """Newton's gravity between all pairs of centres of mass."""

    gm: Annotated[Floats, "n"]  # m^3/s^2; empty where bodies do not attract each other


class Gradients(NamedTuple):
    """What the extent of body b adds to the attraction of a."""

    a: Annotated[Ints, "k"]
    b: Annotated[Ints, "k"]
    gm: Annotated[Floats, "k"]  # m^3/s^2, of a


class SpatialGroups(NamedTuple):
    """Every array of a compiled spatial scene."""

    bodies: Bodies
    slots: Slots
    loops: Loops
    points: shared.Points
    products: Products
    planes: shared.Planes
    distances: shared.Distances
    turns: Turns
    drives: shared.Drives
    wheels: Wheels
    forces: Forces
    springs: shared.Springs
    torsion_springs: TorsionSprings
    bushings: Bushings
    contact_pairs: shared.ContactPairs
    contact_laws: ContactLaws
    contact_modes: ContactModes
    near_pairs: NearPairs
    watches: shared.Watches
    attraction: Attraction
    gradients: Gradients
    signals: SignalArrays
    world: shared.World


products_of = accessor("products")
turns_of = accessor("turns")
wheels_of = accessor("wheels")
bushings_of = accessor("bushings")
attraction_of = accessor("attraction")
gradients_of = accessor("gradients")
grips_of = accessor("grips")


class Kinematics(NamedTuple):
    """Last row: ground."""

    position: Annotated[Floats, "n + 1", 3]  # m
    turned: Annotated[Floats, "n + 1", 3, 3]  # A(theta / |theta|)
    theta: Annotated[Floats, "n + 1", 4]  # Euler parameters as the state has them
    norm: Annotated[Floats, "n + 1"]  # theta . theta - 1
    velocity: Annotated[Floats, "n + 1", 3]  # m/s
    omega: Annotated[Floats, "n + 1", 3]  # rad/s, world
    inertia: Annotated[Floats, "n + 1", 6]  # world axes: xx, yy, zz, xy, xz, yz
    force: Annotated[Floats, "n + 1", 6]  # N; N m about the centre of mass
    user: Annotated[Floats, 3, "n", 7]  # q, v and f in scene order, for a user's force law


class Tree(NamedTuple):
    articulated: Annotated[Floats, "n + 1", 6, 6]  # lower triangle, factored in place
    row_factor: Annotated[Floats, "n", 6, 6]  # L D L^T of J M^-1 J^T
    lift: Annotated[Floats, "n", 6, 6]  # row r: M^-1 J^T of joint row r
    transfer: Annotated[Floats, "n", 6, 6]  # (J M^-1 J^T)^-1 K
    free: Annotated[Floats, "n", 6]  # M^-1 f of the pass under way
    load: Annotated[Floats, "n + 1", 6]  # f accumulated
    acceleration: Annotated[Floats, "n + 1", 6]  # the solution of the pass, ground row zero


class Grips(NamedTuple):
    deflection: Annotated[Floats, "n_sticking", 2]  # m, of the springs of sticking contacts along the plane's edges


class SpatialScratch(NamedTuple):
    """Scratch of one run."""

    kinematics: Kinematics
    rows: shared.Rows
    tree: Tree
    closures: Closures
    solved: shared.Solved
    grips: Grips
