"""Elementary constraint rows between two bodies a and b, of which joints consist.

Points (m) and unit vectors are the world's at t = 0; each is fixed in the body of its name. Source of the spatial
rows: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sec. 9.4.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from mbs_ref.scene.base.part import normals, unit

Point = tuple[float, ...]
Names = Sequence[str]  # of bodies
Column = Callable[[str], list[Any]]


class Axes(Protocol):
    """The bodies of a scene by name, and their places and axes at t = 0."""

    def body(self, name: str) -> int: ...
    def angle(self, name: str) -> float: ...  # rad, in the plane
    def points(self, names: Names, world: Any) -> np.ndarray: ...  # of world points, each in a body's axes, m
    def directions(self, names: Names, world: Any) -> np.ndarray: ...  # of world directions, each in a body's axes


class Row:
    """One elementary row, or a few that always come together."""

    TURNS: ClassVar[bool] = False  # whether it acts on the bodies' orientation alone
    GROUP: ClassVar[str] = ""  # the group of arrays that it fills (mbs_ref/kernels/*/model.py)

    @property
    def count(self) -> int:
        return 1

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        """Return the arrays of the group for rows of which `of` lists a field, in the axes of their bodies a and b."""
        raise NotImplementedError("this kind of row names no numbers")


@dataclass(frozen=True)
class SharedPoint(Row):
    """Rows r_b - r_a = 0 along the world axes: two in the plane, three in space."""

    point_a: Point
    point_b: Point
    GROUP: ClassVar[str] = "points"

    @property
    def count(self) -> int:
        return len(self.point_a)

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        return axes.points(a, of("point_a")), axes.points(b, of("point_b"))


@dataclass(frozen=True)
class OnPlane(Row):
    """n . (r_b - r_a) = 0; in the plane a point of b stays on a line of a."""

    point_a: Point
    point_b: Point
    normal: np.ndarray  # fixed in a
    GROUP: ClassVar[str] = "planes"

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        return axes.points(a, of("point_a")), axes.points(b, of("point_b")), axes.directions(a, of("normal"))


@dataclass(frozen=True)
class Rod(Row):
    """|r_b - r_a| = length."""

    point_a: Point
    point_b: Point
    length: float  # m
    GROUP: ClassVar[str] = "distances"

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        return axes.points(a, of("point_a")), axes.points(b, of("point_b")), of("length")


@dataclass(frozen=True)
class Product(Row):
    """e_a . e_b = 0 (space)."""

    along_a: np.ndarray
    along_b: np.ndarray
    GROUP: ClassVar[str] = "products"
    TURNS: ClassVar[bool] = True

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        return axes.directions(a, of("along_a")), axes.directions(b, of("along_b"))


@dataclass(frozen=True)
class SameAngle(Row):
    """theta_b - theta_a stays what it is at t = 0 (plane)."""

    GROUP: ClassVar[str] = "angles"
    TURNS: ClassVar[bool] = True

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        return ([axes.angle(of_b) - axes.angle(of_a) for of_a, of_b in zip(a, b, strict=True)],)


@dataclass(frozen=True)
class Turn(Row):
    """sin(angle - motion) = 0, the angle of b about an axis of a (space)."""

    zero: np.ndarray  # across the axis
    quarter: np.ndarray  # axis x zero
    GROUP: ClassVar[str] = "turns"
    TURNS: ClassVar[bool] = True

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        return axes.directions(a, of("zero")), axes.directions(a, of("quarter")), axes.directions(b, of("zero"))


@dataclass(frozen=True)
class PrescribedAngle(Row):
    """theta_b - theta_b(0) = motion (plane)."""

    GROUP: ClassVar[str] = "angle_drives"
    TURNS: ClassVar[bool] = True

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        return (list(map(axes.angle, b)),)


@dataclass(frozen=True)
class Prescribed(Row):
    """direction . (r_b - r_b(0)) = motion."""

    point: Point | None  # None: the centre of mass
    direction: np.ndarray
    GROUP: ClassVar[str] = "drives"

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        points, directions = of("point"), of("direction")
        starts = [float(along @ point) for along, point in zip(directions, points, strict=True)]
        return axes.points(b, points), directions, starts


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

    @staticmethod
    def numbers(axes: Axes, of: Column, a: Names, b: Names) -> tuple[Any, ...]:
        frames = [np.array([*normals(tuple(normal)), normal]) for normal in of("normal")]
        heights = [float(normal @ lowest()) for normal, lowest in zip(of("normal"), of("lowest"), strict=True)]
        return axes.points(b, of("centre")), axes.directions(b, of("axis")), of("radius"), frames, heights


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
