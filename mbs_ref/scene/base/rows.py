"""Elementary constraint rows between two bodies a and b, of which joints consist.

Points (m) and unit vectors are the world's at t = 0; each is fixed in the body of its name. Source of the spatial
rows: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sec. 9.4.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from mbs_ref.scene.base.part import normals, unit

Point = tuple[float, ...]


class Axes(Protocol):
    """The bodies of a scene by name, and their places and axes at t = 0."""

    def body(self, name: str) -> int: ...
    def angle(self, name: str) -> float: ...  # rad, in the plane
    def point(self, name: str, world: Any) -> np.ndarray: ...  # of a world point, in body axes, m
    def direction(self, name: str, world: Any) -> np.ndarray: ...  # of a world direction, in body axes


class Row:
    """One elementary row, or a few that always come together."""

    TURNS: ClassVar[bool] = False  # whether it acts on the bodies' orientation alone
    GROUP: ClassVar[str] = ""  # the group of arrays that it fills (mbs_ref/kernels/*/model.py)

    @property
    def count(self) -> int:
        return 1

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        """Return its numbers in the axes of the bodies a and b, in the order of its group's arrays."""
        raise NotImplementedError(f"{type(self).__name__} names no numbers")


@dataclass(frozen=True)
class SharedPoint(Row):
    """Rows r_b - r_a = 0 along the world axes: two in the plane, three in space."""

    point_a: Point
    point_b: Point
    GROUP: ClassVar[str] = "points"

    @property
    def count(self) -> int:
        return len(self.point_a)

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return axes.point(a, self.point_a), axes.point(b, self.point_b)


@dataclass(frozen=True)
class OnPlane(Row):
    """n . (r_b - r_a) = 0; in the plane a point of b stays on a line of a."""

    point_a: Point
    point_b: Point
    normal: np.ndarray  # fixed in a
    GROUP: ClassVar[str] = "planes"

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return axes.point(a, self.point_a), axes.point(b, self.point_b), axes.direction(a, self.normal)


@dataclass(frozen=True)
class Rod(Row):
    """|r_b - r_a| = length."""

    point_a: Point
    point_b: Point
    length: float  # m
    GROUP: ClassVar[str] = "distances"

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return axes.point(a, self.point_a), axes.point(b, self.point_b), self.length


@dataclass(frozen=True)
class Product(Row):
    """e_a . e_b = 0 (space)."""

    along_a: np.ndarray
    along_b: np.ndarray
    GROUP: ClassVar[str] = "products"
    TURNS: ClassVar[bool] = True

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return axes.direction(a, self.along_a), axes.direction(b, self.along_b)


@dataclass(frozen=True)
class SameAngle(Row):
    """theta_b - theta_a stays what it is at t = 0 (plane)."""

    GROUP: ClassVar[str] = "angles"
    TURNS: ClassVar[bool] = True

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return (axes.angle(b) - axes.angle(a),)


@dataclass(frozen=True)
class Turn(Row):
    """sin(angle - motion) = 0, the angle of b about an axis of a (space)."""

    zero: np.ndarray  # across the axis
    quarter: np.ndarray  # axis x zero
    GROUP: ClassVar[str] = "turns"
    TURNS: ClassVar[bool] = True

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return axes.direction(a, self.zero), axes.direction(a, self.quarter), axes.direction(b, self.zero)


@dataclass(frozen=True)
class PrescribedAngle(Row):
    """theta_b - theta_b(0) = motion (plane)."""

    GROUP: ClassVar[str] = "angle_drives"
    TURNS: ClassVar[bool] = True

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return (axes.angle(b),)


@dataclass(frozen=True)
class Prescribed(Row):
    """direction . (r_b - r_b(0)) = motion."""

    point: Point | None  # None: the centre of mass
    direction: np.ndarray
    GROUP: ClassVar[str] = "drives"

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        return axes.point(b, self.point), self.direction, float(self.direction @ self.point)


@dataclass(frozen=True)
class RollingContact(Row):
    """The matter of b at the lowest point of its rim is at rest: three rows on velocities (space).

    Along the normal it is the rate of a row on positions, the height of that point; along the plane no C is behind it.
    """

    centre: Point
    axis: np.ndarray  # fixed in b
    radius: float  # m
    normal: np.ndarray  # of the plane, world
    GROUP: ClassVar[str] = "wheels"

    @property
    def count(self) -> int:
        return 3

    def lowest(self) -> np.ndarray:
        """Return the point (3,) of the rim, m, that is on the plane at t = 0."""
        down = np.dot(self.normal, self.axis) * self.axis - self.normal
        return np.asarray(self.centre) + self.radius * unit(tuple(down))

    def numbers(self, axes: Axes, a: str, b: str) -> tuple[Any, ...]:
        frame = np.array([*normals(tuple(self.normal)), self.normal])
        centre, axis = axes.point(b, self.centre), axes.direction(b, self.axis)
        return centre, axis, self.radius, frame, float(self.normal @ self.lowest())


@dataclass(frozen=True)
class UserRow(Row):
    """C(t, a, b) = 0 of the user's own; what it leaves of either body's freedom is not known beforehand."""

    function: Callable[[Any, Any, Any], Any]


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
