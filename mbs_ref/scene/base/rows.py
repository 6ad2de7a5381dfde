"""What joints are made of: elementary constraint rows between two bodies a and b.

Points (m) and unit vectors are the world's at t = 0; each is carried by the body its name says. Source of the spatial
rows: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sec. 9.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mbs_ref.scene.base.directions import normals, unit

Point = tuple[float, ...]


class Row:
    """One elementary row, or a few that always come together."""

    TURNS: ClassVar[bool] = False  # whether it acts on the bodies' orientation alone

    @property
    def count(self) -> int:
        return 1


@dataclass(frozen=True)
class SharedPoint(Row):
    """Rows r_b - r_a = 0 along the world axes: two in the plane, three in space."""

    point_a: Point
    point_b: Point

    @property
    def count(self) -> int:
        return len(self.point_a)


@dataclass(frozen=True)
class OnPlane(Row):
    """n . (r_b - r_a) = 0; in the plane a point of b stays on a line of a."""

    point_a: Point
    point_b: Point
    normal: np.ndarray  # fixed in a


@dataclass(frozen=True)
class Rod(Row):
    """|r_b - r_a| = length."""

    point_a: Point
    point_b: Point
    length: float  # m


@dataclass(frozen=True)
class Product(Row):
    """e_a . e_b = 0 (space)."""

    along_a: np.ndarray
    along_b: np.ndarray
    TURNS: ClassVar[bool] = True


@dataclass(frozen=True)
class SameAngle(Row):
    """theta_b - theta_a stays what it is at t = 0 (plane)."""

    TURNS: ClassVar[bool] = True


@dataclass(frozen=True)
class Turn(Row):
    """sin(angle - motion) = 0, the angle of b about an axis of a (space)."""

    zero: np.ndarray  # across the axis
    quarter: np.ndarray  # axis x zero
    TURNS: ClassVar[bool] = True


@dataclass(frozen=True)
class PrescribedAngle(Row):
    """theta_b - theta_b(0) = motion (plane)."""

    TURNS: ClassVar[bool] = True


@dataclass(frozen=True)
class Prescribed(Row):
    """direction . (r_b - r_b(0)) = motion."""

    point: Point | None  # None: the centre of mass
    direction: np.ndarray


def parallel(axis: tuple[float, ...]) -> list[Row]:
    """Return the two rows that keep an axis of b parallel to the same axis of a."""
    return [Product(normal, unit(axis)) for normal in normals(axis)]


def along(point: Point, axis: tuple[float, ...]) -> list[Row]:
    """Return the rows that keep a point of b on the line through it along an axis of a."""
    across = normals(axis) if len(axis) == 3 else (unit((-axis[1], axis[0])),)
    return [OnPlane(point, point, normal) for normal in across]


def same_orientation(dimension: int) -> list[Row]:
    """Return the rows that keep b from turning relative to a."""
    if dimension == 2:
        return [SameAngle()]
    x, y, z = np.eye(3)
    return [Product(x, y), Product(y, z), Product(z, x)]
