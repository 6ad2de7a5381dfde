"""The arrays that planar scenes alone have, besides those of `rigid.model`.

A body has the coordinates Rx, Ry, theta; the third of a point mass stays at rest.
"""

from typing import Annotated, NamedTuple

from mbs_ref.kernels.border.groups import Floats, Ints, joined
from mbs_ref.kernels.rigid import model as shared

RATES = tuple(range(3))  # of a body: a loop over it has bounds that the compiler knows


class Angles(NamedTuple):
    """theta_b - theta_a = value: one row."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side_a: Annotated[Ints, "k"]  # which side of the slot is body_a
    value: Annotated[Floats, "k"]  # rad


class AngleDrives(NamedTuple):
    """theta - start = signal: one row, the other side is ground."""

    slot: Annotated[Ints, "k"]
    row: Annotated[Ints, "k"]
    side: Annotated[Ints, "k"]  # which side of the slot is the body
    start: Annotated[Floats, "k"]  # rad
    signal: Annotated[Ints, "k"]


PlanarGroups = joined("PlanarGroups", shared.GROUPS, angles=Angles, angle_drives=AngleDrives)


class Kinematics(NamedTuple):
    """Last row: ground."""

    pose: Annotated[Floats, "n + 1", 4]  # x, y, cos, sin
    motion: Annotated[Floats, "n + 1", 4]  # vx, vy, omega, theta
    force: Annotated[Floats, "n + 1", 3]  # N, N, N m
    user: Annotated[Floats, 3, "n", 3]  # q, v and f in scene order, for a user's force law


PlanarScratch = joined("PlanarScratch", {"kinematics": Kinematics}, shared.SCRATCH)
