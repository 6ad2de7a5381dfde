"""The joints of a scene, and the drives that prescribe a motion. Points and axes are the world's at t = 0."""

import math
from collections import namedtuple
from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, SkipValidation, model_validator

from mbs_ref.scene.base import part, rows
from mbs_ref.scene.base.attached import COORDINATES, NO_ORIENTATION, Attached, AttachedPair, coordinate_complaints
from mbs_ref.scene.base.expression import Read, read
from mbs_ref.scene.base.rows import Row
from mbs_ref.scene.signals import Level, Signal

FLAT = 1e-6  # sine of the angle between a wheel's axis and the normal below which it lies flat


class JointPart(Attached):
    """A joint, a set of elementary constraint rows; solvers use these alone."""

    def rows(self, dimension: int) -> list[Row]:
        """Return its rows in the plane (2) or in space (3); valid if `complaints` yields nothing."""
        raise NotImplementedError(f"{type(self).__name__} names no rows")

    def refuses_particle(self, end: str, dimension: int) -> str:
        return NO_ORIENTATION if any(row.TURNS for row in self.rows(dimension)) else ""


class PairJoint(JointPart, AttachedPair):
    """A joint between two bodies, or a body and ground."""


class Drive(JointPart):
    """A joint that prescribes a motion in time."""

    motion: Signal  # m or rad; counted from its own value at t = 0
    level: Level = "position"  # the derivative of the displacement that `motion` gives


def axis_complaints(kind: str, axis: tuple[float, ...] | None, dimension: int) -> Iterator[str]:
    """Yield complaints about the axis of a part that turns about the normal in the plane."""
    if (axis is None) != (dimension == 2):
        superfluous = f"axis = {axis}: in the plane a {kind} turns about the normal; leave the axis out"
        yield superfluous if axis else f"a {kind} in space needs an axis"


class Revolute(PairJoint):
    """Two bodies share a point (planar: 2 rows); in space also an axis through it (5 rows)."""

    type: Literal["revolute"] = "revolute"
    point: part.Point  # m, world, t = 0
    point_b: part.Point | None = None  # m, where body b's mark is at t = 0 when the loop is still open
    axis: part.Direction | None = None  # direction, world, t = 0; required in space, forbidden in the plane

    def complaints(self, dimension: int) -> Iterator[str]:
        yield from axis_complaints(self.type, self.axis, dimension)

    def rows(self, dimension: int) -> list[Row]:
        shared = rows.SharedPoint(*self.marks)
        return [shared] if self.axis is None else [shared, *rows.parallel(self.axis)]


class Spherical(PairJoint):
    """Two bodies share a point (space: 3 rows)."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)
    COUNTERPART: ClassVar[str] = "revolute"

    type: Literal["spherical"] = "spherical"
    point: part.Point3  # m, world, t = 0

    def rows(self, dimension: int) -> list[Row]:
        return [rows.SharedPoint(self.point, self.point)]


class Universal(PairJoint):
    """Two bodies share a point, and an axis of one stays perpendicular to an axis of the other (4 rows)."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)

    type: Literal["universal"] = "universal"
    point: part.Point3  # m, world, t = 0
    axis_a: part.Direction3  # direction fixed in body a, world, t = 0
    axis_b: part.Direction3  # direction fixed in body b, world, t = 0; perpendicular to axis_a

    @model_validator(mode="after")
    def _check(self) -> Self:
        part.require_perpendicular("axis_a", self.axis_a, "axis_b", self.axis_b)
        return self

    def rows(self, dimension: int) -> list[Row]:
        return [rows.SharedPoint(self.point, self.point), rows.Product(part.unit(self.axis_a), part.unit(self.axis_b))]


class Cylindrical(PairJoint):
    """Body b slides along an axis fixed in body a and turns about it (space: 4 rows)."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)

    type: Literal["cylindrical"] = "cylindrical"
    point: part.Point3  # m, world, t = 0
    axis: part.Direction3  # direction, world, t = 0

    def rows(self, dimension: int) -> list[Row]:
        return [*rows.along(self.point, self.axis), *rows.parallel(self.axis)]


class PointOnPlane(PairJoint):
    """A point of body b stays on a plane fixed in body a (space: 1 row)."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)

    type: Literal["point_on_plane"] = "point_on_plane"
    point: part.Point3  # m, world, t = 0
    normal: part.Direction3  # direction, world, t = 0

    def rows(self, dimension: int) -> list[Row]:
        return [rows.OnPlane(self.point, self.point, part.unit(self.normal))]


class Prismatic(PairJoint):
    """Body b slides along an axis fixed in body a without turning (planar: 2 rows; space: 5)."""

    type: Literal["prismatic"] = "prismatic"
    point: part.Point  # m, world, t = 0
    axis: part.Direction  # world, t = 0

    def rows(self, dimension: int) -> list[Row]:
        return [*rows.along(self.point, self.axis), *rows.same_orientation(dimension)]


class Weld(PairJoint):
    """No relative motion (planar: 3 rows; space: 6)."""

    type: Literal["weld"] = "weld"
    point: part.Point  # m, world, t = 0
    point_b: part.Point | None = None  # m, where body b's mark is at t = 0 when the loop is still open

    def rows(self, dimension: int) -> list[Row]:
        return [rows.SharedPoint(*self.marks), *rows.same_orientation(dimension)]


class Distance(PairJoint):
    """A massless rod between two points (1 row); its length is their distance at t = 0 unless given."""

    type: Literal["distance"] = "distance"
    point_a: part.Point  # m, world, t = 0
    point_b: part.Point  # m, world, t = 0
    length: part.Positive | None = None  # m

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.length is None and math.dist(self.point_a, self.point_b) == 0.0:
            raise ValueError("point_a and point_b coincide; a distance joint needs a length > 0")
        return self

    def rows(self, dimension: int) -> list[Row]:
        length = math.dist(self.point_a, self.point_b) if self.length is None else self.length
        return [rows.Rod(self.point_a, self.point_b, length)]


class RollingWheel(JointPart):
    """A knife-edged wheel rolls on a plane of ground without slipping (space: 3 rows, two of them on velocities alone).

    The plane touches the rim's lowest point at t = 0. The two rows along the plane are nonholonomic: they constrain
    how the wheel moves, not where it is. The wheel may lean, and stays on the plane whatever the force.
    """

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)
    TURNS: ClassVar[bool] = True

    type: Literal["rolling_wheel"] = "rolling_wheel"
    body: part.BodyName
    point: part.Point3  # m, the centre, world, t = 0
    axis: part.Direction3  # of the wheel, world, t = 0
    radius: part.Positive  # m
    normal: part.Direction3  # of the plane, out of ground, world

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not float(np.linalg.norm(np.cross(part.unit(self.axis), part.unit(self.normal)))) > FLAT:
            raise ValueError(f"axis = {self.axis} is along the normal: a wheel that lies flat has no lowest point")
        return self

    def refuses_particle(self, end: str, dimension: int) -> str:
        return NO_ORIENTATION

    def rows(self, dimension: int) -> list[Row]:
        return [rows.RollingContact(self.point, part.unit(self.axis), self.radius, part.unit(self.normal))]


class CoordinateDrive(Drive):
    """A coordinate of a body follows its initial value plus a motion (rheonomic, 1 row)."""

    type: Literal["coordinate_drive"] = "coordinate_drive"
    body: part.BodyName
    coordinate: Literal["x", "y", "z", "angle"]  # z in space alone, angle in the plane alone

    def complaints(self, dimension: int) -> Iterator[str]:
        yield from coordinate_complaints(self.coordinate, dimension, "; use rotation_drive")

    def rows(self, dimension: int) -> list[Row]:
        if self.coordinate == "angle":
            return [rows.PrescribedAngle()]
        return [rows.Prescribed(None, np.eye(dimension)["xyz".index(self.coordinate)])]


class PointDrive(Drive):
    """A point of a body follows its initial place plus a motion along a fixed direction (1 row)."""

    type: Literal["point_drive"] = "point_drive"
    body: part.BodyName
    point: part.Point  # m, world, t = 0
    direction: part.Direction  # world

    def rows(self, dimension: int) -> list[Row]:
        return [rows.Prescribed(self.point, part.unit(self.direction))]


class RotationDrive(Drive):
    """Body b turns about an axis fixed in body a by a prescribed angle, right-handed (space, rheonomic, 1 row).

    It goes with a joint that keeps the axis: a constant `motion` at the level `velocity` drives at constant
    angular velocity.
    """

    DIMENSIONS: ClassVar[tuple[int, ...]] = (3,)

    type: Literal["rotation_drive"] = "rotation_drive"
    body_a: part.EndName
    body_b: part.EndName
    axis: part.Direction3  # direction, world, t = 0

    def rows(self, dimension: int) -> list[Row]:
        return [rows.Turn(*part.normals(self.axis))]


# of a body in a UserConstraint
PlanarPlace = namedtuple("PlanarPlace", COORDINATES[2])
SpatialPlace = namedtuple("SpatialPlace", (*COORDINATES[3], "e0", "e1", "e2", "e3"))
PLACES: dict[int, Any] = {2: PlanarPlace, 3: SpatialPlace}


class UserConstraint(PairJoint):
    """C(t, a, b) = 0 of the user's own, between two bodies or a body and ground (1 row).

    a and b have x, y (and z in space), m: where the point is that is at point_a and point_b at t = 0, the centre of
    mass unless given; and `angle` (rad), or in space the Euler parameters e0..e3. The expression is written with these,
    as "hypot(b.x - a.x, b.y - a.y) - 0.5 - 0.1 * sin(3 * t)", and goes into files. A function(t, a, b) is called with
    numbers that carry their derivatives (mbs_ref.scene.base.taylor): use NumPy's functions, not Python's math. Either
    is slow, as a user's force is; a function does not write to TOML. C is twice differentiable, its unit m or rad.
    """

    type: Literal["user_constraint"] = "user_constraint"
    point_a: part.Point | None = None  # m, world, t = 0
    point_b: part.Point | None = None  # m, world, t = 0
    expression: str | None = None  # C, in m or rad
    function: Annotated[Callable[..., Any] | None, SkipValidation] = None  # of Python alone

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.expression is None) == (self.function is None):
            raise ValueError("give either an expression or a function")
        if self.function is not None and not callable(self.function):
            raise ValueError(f"function = {self.function!r} is no function; in a file give an expression")
        self._read()
        return self

    def _read(self) -> Read | None:
        return None if self.expression is None else read(self.expression)

    @property
    def depends_on_time(self) -> bool:
        """Whether the time may be in it; a function is not looked into."""
        formula = self._read()
        return formula is None or "t" in formula.names

    def complaints(self, dimension: int) -> Iterator[str]:
        formula = self._read()
        if formula is None:
            return
        every = sorted(f"{end}.{name}" for end in "ab" for name in PLACES[dimension]._fields)
        unknown = sorted(formula.names - {"t", *every})
        if unknown:
            yield f"the expression has {', '.join(unknown)}; allowed here: t, {', '.join(every)}"
        elif formula.names <= {"t"}:
            yield f"expression = {self.expression!r} has no coordinate of a body in it"

    def formula(self) -> Callable[[Any, Any, Any], Any]:
        """Return C as a function of t (s) and the coordinates of both ends."""
        formula = self._read()
        if formula is not None:
            return formula.formula
        assert self.function is not None
        return self.function

    def rows(self, dimension: int) -> list[Row]:
        return [rows.UserRow(self.formula())]


Kinematic = Revolute | Spherical | Universal | Cylindrical | Prismatic | Weld | Distance | PointOnPlane | RollingWheel
Joint = Annotated[
    Kinematic | CoordinateDrive | PointDrive | RotationDrive | UserConstraint, Field(discriminator="type")
]
