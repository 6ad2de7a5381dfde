"""The arrays that spatial scenes alone have, besides those of `rigid.model`.

A rigid body has the coordinates R and theta0..theta3 and the rates R', omega; a point mass has R and R'
alone. Joints are broken up into five element types: shared points, products of directions, points on
planes, distances and prescribed turns.
"""

from typing import Annotated, NamedTuple

from mbs_ref.kernels.border.groups import Floats, Ints, joined
from mbs_ref.kernels.rigid import model as shared

RATES = tuple(range(6))  # of a body: a loop over it has bounds that the compiler knows


class Products(NamedTuple):
    """e_a . e_b = 0 of two directions that are to stay perpendicular: one row."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side_a: Annotated[Ints, "k"]
    along_a: Annotated[Floats, "k", 3]  # unit vector, in body a
    along_b: Annotated[Floats, "k", 3]  # unit vector, in body b


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


SpatialGroups = joined(
    "SpatialGroups", shared.GROUPS, products=Products, turns=Turns, wheels=Wheels,
    bushings=Bushings, attraction=Attraction, gradients=Gradients,
)  # fmt: skip


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


class Grips(NamedTuple):
    deflection: Annotated[Floats, "n_sticking", 2]  # m, of the springs of sticking contacts along the plane's edges


SpatialScratch = joined("SpatialScratch", {"kinematics": Kinematics}, shared.SCRATCH, grips=Grips)
