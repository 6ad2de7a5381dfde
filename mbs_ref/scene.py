"""The language of scenes: bodies, joints, drives and loads, on two pages.

A scene is plain frozen data in SI units. Joints and attachment points are given as world points and
axes at t = 0. Traits (planar or spatial, closed loops, rheonomic terms) are computed, never typed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SkipValidation, model_validator

from mbs_ref.part import Name, NonNegative, Part, Positive, Vector
from mbs_ref.signals import Constant, Level, Signal, breakpoints

GROUND = "ground"


# --- bodies ---------------------------------------------------------------------------------------


class PlanarBody(Part):
    """A rigid body in the plane, q = [Rx, Ry, theta] at its centre of mass (Fox 1999 eq 1)."""

    type: Literal["planar"] = "planar"
    name: Name
    mass: Positive  # kg
    inertia: Positive  # kg m^2, about the centre of mass
    position: tuple[float, float] = (0.0, 0.0)  # m, centre of mass at t = 0
    angle: float = 0.0  # rad
    velocity: tuple[float, float] = (0.0, 0.0)  # m/s
    angular_velocity: float = 0.0  # rad/s


class PointMass(Part):
    """A particle; it has a position and no orientation."""

    type: Literal["point_mass"] = "point_mass"
    name: Name
    mass: Positive  # kg
    position: Vector  # m
    velocity: Vector  # m/s


Body = Annotated[PlanarBody | PointMass, Field(discriminator="type")]


# --- joints ---------------------------------------------------------------------------------------


class Revolute(Part):
    """Two bodies share a point (planar: 2 rows)."""

    type: Literal["revolute"] = "revolute"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector  # m, world, t = 0
    point_b: Vector | None = None  # m, where body b's mark is at t = 0 when the loop is still open


class Prismatic(Part):
    """Body b slides along an axis fixed in body a without turning (planar: 2 rows)."""

    type: Literal["prismatic"] = "prismatic"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector  # m, world, t = 0
    axis: Vector  # direction, world, t = 0; any length but zero

    @model_validator(mode="after")
    def _check(self) -> Self:
        _require_direction("axis", self.axis)
        return self


class Weld(Part):
    """No relative motion (planar: 3 rows)."""

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
    coordinate: Literal["x", "y", "angle"]
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
        _require_direction("direction", self.direction)
        return self


Joint = Annotated[
    Revolute | Prismatic | Weld | Distance | CoordinateDrive | PointDrive, Field(discriminator="type")
]


# --- loads ----------------------------------------------------------------------------------------


class Force(Part):
    """A force at a point of a body: vector times a signal, along fixed world or body axes."""

    type: Literal["force"] = "force"
    name: Name
    body: Name
    point: Vector  # m, world, t = 0
    vector: Vector  # N
    frame: Literal["world", "body"] = "world"
    factor: Signal = Constant()


class Torque(Part):
    """A torque on a body times a signal."""

    type: Literal["torque"] = "torque"
    name: Name
    body: Name
    torque: float  # N m
    factor: Signal = Constant()


class SpringDamper(Part):
    """A point-to-point spring and damper: F = k (l - l0) + c dl/dt, optionally in tension only."""

    type: Literal["spring_damper"] = "spring_damper"
    name: Name
    body_a: Name
    body_b: Name
    point_a: Vector  # m, world, t = 0
    point_b: Vector  # m, world, t = 0
    stiffness: NonNegative  # N/m
    damping: NonNegative = 0.0  # N s/m
    rest_length: NonNegative | None = None  # m; the distance at t = 0 unless given
    tension_only: bool = False  # slack below the rest length, and never pushing


class TorsionSpring(Part):
    """A rotational spring and damper on the relative angle of two bodies."""

    type: Literal["torsion_spring"] = "torsion_spring"
    name: Name
    body_a: Name
    body_b: Name
    stiffness: NonNegative  # N m/rad
    damping: NonNegative = 0.0  # N m s/rad
    rest_angle: float | None = None  # rad, of b relative to a; the initial one unless given


class UserForce(Part):
    """A user's own force law, called as function(t, q, v) -> generalized forces.

    q, v and the result have shape (n_bodies, 3) in the scene's body order: m, m, rad; N, N, N m. A
    Python function is slow and is reported as such. It does not write to TOML.
    """

    type: Literal["user_force"] = "user_force"
    name: Name
    function: Annotated[Callable[..., Any], SkipValidation]


Load = Annotated[
    Force | Torque | SpringDamper | TorsionSpring | UserForce, Field(discriminator="type")
]


# --- the scene ------------------------------------------------------------------------------------


class Scene(Part):
    """Bodies, joints, loads and gravity, checked as a whole."""

    name: Name
    description: str = ""
    source: str = ""  # where the data come from
    duration: Positive = 1.0  # s, how long a run lasts unless told otherwise
    gravity: Vector = (0.0, 0.0)  # m/s^2
    bodies: tuple[Body, ...] = Field(min_length=1, max_length=100_000)
    joints: tuple[Joint, ...] = ()
    loads: tuple[Load, ...] = ()
    parameters: dict[str, float | int | str | bool] = {}  # what the scene was built with

    @model_validator(mode="after")
    def _check(self) -> Self:
        for k, body in enumerate(self.bodies):
            if len(body.position) != self.dimension or len(body.velocity) != self.dimension:
                raise ValueError(f"bodies.{k} ({body.name}): position and velocity need {self.dimension} components")
        if len(self.gravity) != self.dimension:
            raise ValueError(f"gravity = {self.gravity} must have {self.dimension} components here")
        _require_unique("body", [body.name for body in self.bodies], reserved=GROUND)
        _require_unique("joint", [joint.name for joint in self.joints])
        _require_unique("load", [load.name for load in self.loads])
        for kind, parts in (("joints", self.joints), ("loads", self.loads)):
            for k, part in enumerate(parts):
                self._check_references(f"{kind}.{k} ({part.name})", part)
        return self

    def _check_references(self, where: str, part: Part) -> None:
        names = {body.name: body for body in self.bodies}
        for field in ("body", "body_a", "body_b"):
            named = getattr(part, field, None)
            if named is None:
                continue
            if named in names:
                _check_particle(f"{where}: {field}", part, field, names[named])
                continue
            if named == GROUND and field != "body":
                continue
            raise ValueError(f"{where}: {field} = {named!r} is no body of the scene; {_listing(set(names))}")
        a, b = getattr(part, "body_a", None), getattr(part, "body_b", None)
        if a is not None and a == b:
            raise ValueError(f"{where}: body_a and body_b are both {a!r}; they must differ")
        self._check_dimensions(where, part)

    def _check_dimensions(self, where: str, part: Part) -> None:
        for field in ("point", "point_a", "point_b", "axis", "direction", "vector"):
            value = getattr(part, field, None)
            if value is not None and len(value) != self.dimension:
                raise ValueError(f"{where}: {field} = {value} must have {self.dimension} components here")

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space: what the bodies are made of."""
        return max(2 if isinstance(b, PlanarBody) else len(b.position) for b in self.bodies)

    @property
    def body_names(self) -> list[str]:
        return [body.name for body in self.bodies]

    def body_index(self, name: str) -> int:
        """Return the body's place in `bodies`; -1 for ground."""
        return -1 if name == GROUND else self.body_names.index(name)

    def breakpoints(self) -> list[float]:
        """Return the sorted times (s) at which a declared signal may be non-smooth."""
        signals = [load.factor for load in self.loads if isinstance(load, Force | Torque)]
        signals += [j.motion for j in self.joints if isinstance(j, CoordinateDrive | PointDrive)]
        return sorted({t for signal in signals for t in breakpoints(signal)})


def _require_direction(field: str, value: tuple[float, ...]) -> None:
    if not math.hypot(*value) > 0.0:  # neither overflows nor underflows
        raise ValueError(f"{field} = {value} has no direction; give any vector but zero")


_TURNING_PARTS = ("prismatic", "weld", "torque", "torsion_spring")


def _check_particle(where: str, part: Any, field: str, body: Any) -> None:
    """Refuse what a particle cannot bear: a torque, or an attachment away from its place."""
    if not isinstance(body, PointMass):
        return
    if part.type in _TURNING_PARTS or getattr(part, "coordinate", None) == "angle":
        raise ValueError(f"{where} = {body.name!r} is a point mass and has no orientation; use a rigid body")
    point = getattr(part, "point" if hasattr(part, "point") else field.replace("body", "point"))
    if field == "body_b" and getattr(part, "type", "") == "revolute" and part.point_b is not None:
        point = part.point_b
    if math.dist(point, body.position) > 1e-12 * max(1.0, *map(abs, body.position)):
        raise ValueError(f"{where} = {body.name!r} is a point mass at {body.position}, but it is attached at {point}")


def _require_unique(kind: str, names: list[str], reserved: str | None = None) -> None:
    seen: set[str] = set()
    for name in names:
        if name == reserved:
            raise ValueError(f"a {kind} may not be named {name!r}, which is reserved")
        if name in seen:
            raise ValueError(f"two {kind} parts are named {name!r}; names must differ")
        seen.add(name)


def _listing(names: set[str], most: int = 12) -> str:
    shown = sorted(names)[:most]
    return f"the bodies are {', '.join(shown)}{' ...' if len(names) > most else ''}, and ground"
