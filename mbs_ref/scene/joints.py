"""The joints of a scene, and the drives that prescribe a motion. Points and axes are the world's at t = 0."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from mbs_ref.scene.directions import require_direction, require_perpendicular
from mbs_ref.scene.part import Name, Part, Positive, Vector, Vector3
from mbs_ref.scene.signals import Level, Signal


class Revolute(Part):
    """Two bodies share a point (planar: 2 rows); in space also an axis through it (5 rows)."""

    type: Literal["revolute"] = "revolute"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector  # m, world, t = 0
    point_b: Vector | None = None  # m, where body b's mark is at t = 0 when the loop is still open
    axis: Vector | None = None  # direction, world, t = 0; in space alone, and there it must be given

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.axis is not None:
            require_direction("axis", self.axis)
        return self


class Spherical(Part):
    """Two bodies share a point (space: 3 rows)."""

    type: Literal["spherical"] = "spherical"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector3  # m, world, t = 0


class Universal(Part):
    """Two bodies share a point, and an axis of one stays perpendicular to an axis of the other (4 rows)."""

    type: Literal["universal"] = "universal"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector3  # m, world, t = 0
    axis_a: Vector3  # direction fixed in body a, world, t = 0
    axis_b: Vector3  # direction fixed in body b, world, t = 0; perpendicular to axis_a

    @model_validator(mode="after")
    def _check(self) -> Self:
        require_perpendicular("axis_a", self.axis_a, "axis_b", self.axis_b)
        return self


class Cylindrical(Part):
    """Body b slides along an axis fixed in body a and turns about it (space: 4 rows)."""

    type: Literal["cylindrical"] = "cylindrical"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector3  # m, world, t = 0
    axis: Vector3  # direction, world, t = 0

    @model_validator(mode="after")
    def _check(self) -> Self:
        require_direction("axis", self.axis)
        return self


class PointOnPlane(Part):
    """A point of body b stays on a plane fixed in body a (space: 1 row)."""

    type: Literal["point_on_plane"] = "point_on_plane"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector3  # m, world, t = 0
    normal: Vector3  # direction, world, t = 0

    @model_validator(mode="after")
    def _check(self) -> Self:
        require_direction("normal", self.normal)
        return self


class Prismatic(Part):
    """Body b slides along an axis fixed in body a without turning (planar: 2 rows; space: 5)."""

    type: Literal["prismatic"] = "prismatic"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector  # m, world, t = 0
    axis: Vector  # direction, world, t = 0; any length but zero

    @model_validator(mode="after")
    def _check(self) -> Self:
        require_direction("axis", self.axis)
        return self


class Weld(Part):
    """No relative motion (planar: 3 rows; space: 6)."""

    type: Literal["weld"] = "weld"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector  # m, world, t = 0
    point_b: Vector | None = None  # m, where body b's mark is at t = 0 when the loop is still open


class Distance(Part):
    """A massless rod between two points (1 row); its length is their distance at t = 0 unless given."""

    type: Literal["distance"] = "distance"
    name: Name
    body_a: Name
    body_b: Name
    point_a: Vector  # m, world, t = 0
    point_b: Vector  # m, world, t = 0
    length: Positive | None = None  # m

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.length is None and math.dist(self.point_a, self.point_b) == 0.0:
            raise ValueError("point_a and point_b coincide; a distance joint needs a length > 0")
        return self


class CoordinateDrive(Part):
    """A coordinate of a body follows its initial value plus a motion (rheonomic, 1 row)."""

    type: Literal["coordinate_drive"] = "coordinate_drive"
    name: Name
    body: Name
    coordinate: Literal["x", "y", "z", "angle"]  # z in space alone, angle in the plane alone
    motion: Signal  # m or rad; counted from its own value at t = 0
    level: Level = "position"  # the derivative of the displacement that `motion` gives


class PointDrive(Part):
    """A point of a body follows its initial place plus a motion along a fixed direction (1 row)."""

    type: Literal["point_drive"] = "point_drive"
    name: Name
    body: Name
    point: Vector  # m, world, t = 0
    direction: Vector  # world; any length but zero
    motion: Signal  # m; counted from its own value at t = 0
    level: Level = "position"

    @model_validator(mode="after")
    def _check(self) -> Self:
        require_direction("direction", self.direction)
        return self


class RotationDrive(Part):
    """Body b turns about an axis fixed in body a by a prescribed angle (space, rheonomic, 1 row).

    It goes with a joint that keeps the axis: a constant `motion` at the level `velocity` drives at constant
    angular velocity.
    """

    type: Literal["rotation_drive"] = "rotation_drive"
    name: Name
    body_a: Name
    body_b: Name
    axis: Vector3  # direction, world, t = 0
    motion: Signal  # rad, right-handed about the axis; counted from its own value at t = 0
    level: Level = "position"

    @model_validator(mode="after")
    def _check(self) -> Self:
        require_direction("axis", self.axis)
        return self


Joint = Annotated[
    Revolute
    | Spherical
    | Universal
    | Cylindrical
    | Prismatic
    | Weld
    | Distance
    | PointOnPlane
    | CoordinateDrive
    | PointDrive
    | RotationDrive,
    Field(discriminator="type"),
]
DRIVES = (CoordinateDrive, PointDrive, RotationDrive)  # what prescribes a motion in time
