"""The language of scenes: bodies, joints, drives and loads, on two pages.

A scene is plain frozen data in SI units. Joints and attachment points are given as world points and
axes at t = 0. Traits (planar or spatial, closed loops, rheonomic terms) are computed, never typed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SkipValidation, model_validator

from mbs_ref.contact import Contact
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


class Bushing(Part):
    """An isotropic spring and damper between two marks that coincide at t = 0: F = k e + c de/dt, e their gap.

    Both forces act at body b's mark, so no couple is left over: momentum is kept, and the damper only takes energy.
    """

    type: Literal["bushing"] = "bushing"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector  # m, world, t = 0
    stiffness: NonNegative  # N/m
    damping: NonNegative = 0.0  # N s/m


class UserForce(Part):
    """A user's own force law, called as function(t, q, v) -> generalized forces.

    q, v and the result have shape (n_bodies, 3) in the scene's body order: m, m, rad; N, N, N m. A
    Python function is slow and is reported as such. It does not write to TOML.
    """

    type: Literal["user_force"] = "user_force"
    name: Name
    function: Annotated[Callable[..., Any], SkipValidation]


Load = Annotated[
    Force | Torque | SpringDamper | TorsionSpring | Bushing | UserForce, Field(discriminator="type")
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
    contacts: tuple[Contact, ...] = ()
    parameters: dict[str, float | int | str | bool] = {}  # what the scene was built with

    @model_validator(mode="after")
    def _check(self) -> Self:
        found = list(_complaints(self))
        if found:
            raise ValueError("\n".join(found))
        return self

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


def _complaints(scene: Scene) -> Iterator[str]:
    """Yield what makes no sense in the scene as a whole, in one pass over its parts."""
    dimension = scene.dimension
    if len(scene.gravity) != dimension:
        yield f"gravity = {scene.gravity} must have {dimension} components here"
    for k, body in enumerate(scene.bodies):
        if len(body.position) != dimension or len(body.velocity) != dimension:
            yield f"bodies[{k}] ({body.name}): position and velocity need {dimension} components"
        if body.name == GROUND:
            yield f"bodies[{k}]: a body may not be named {GROUND!r}, which is reserved"
    bodies = {body.name: body for body in scene.bodies}
    attached = (("joints", scene.joints), ("loads", scene.loads), ("contacts", scene.contacts))
    for kind, parts in (("bodies", scene.bodies), *attached):
        yield from _name_clashes(kind, [part.name for part in parts])
    for kind, parts in attached:
        for k, part in enumerate(parts):
            yield from (f"{kind}[{k}] ({part.name}): {text}" for text in _part_complaints(part, bodies, dimension))


def _name_clashes(kind: str, names: list[str]) -> Iterator[str]:
    first: dict[str, int] = {}
    for k, name in enumerate(names):
        if first.setdefault(name, k) != k:
            yield f"{kind}[{k}]: the name {name!r} is taken by {kind}[{first[name]}]; names must differ"


def _part_complaints(part: Part, bodies: Mapping[str, Body], dimension: int) -> Iterator[str]:
    for field in ("body", "body_a", "body_b"):
        named = getattr(part, field, None)
        if named is None or (named == GROUND and field != "body"):
            continue
        if named not in bodies:
            yield f"{field} = {named!r} is no body of the scene; {_listing(bodies)}"
        elif isinstance(bodies[named], PointMass):
            yield from _particle_complaints(part, field, bodies[named])
    a, b = getattr(part, "body_a", None), getattr(part, "body_b", None)
    if a is not None and a == b:
        yield f"body_a and body_b are both {a!r}; they must differ"
    for field in _VECTORS:
        value = getattr(part, field, None)
        if value is not None and len(value) != dimension:
            yield f"{field} = {value} must have {dimension} components here"


_VECTORS = ("point", "point_a", "point_b", "axis", "direction", "vector") + (
    "center", "center_a", "center_b", "point_1", "point_2", "axle"
)  # fmt: skip
_SHAPED_PARTS = ("circle_on_line", "pin_on_sprocket")  # their body_b carries more than a circle
_TURNING_PARTS = ("prismatic", "weld", "torque", "torsion_spring")


def _particle_complaints(part: Any, field: str, body: Body) -> Iterator[str]:
    """Yield what a particle cannot bear: a torque, or an attachment away from its place."""
    if part.type in _TURNING_PARTS or getattr(part, "coordinate", None) == "angle":
        yield f"{field} = {body.name!r} is a point mass and has no orientation; use a rigid body"
        return
    if getattr(part, "friction", None) is not None or (field == "body_b" and part.type in _SHAPED_PARTS):
        yield f"{field} = {body.name!r} is a point mass: it carries circles without friction only; use a rigid body"
        return
    point = _attachment(part, field)
    if point is None or len(point) != len(body.position):
        return
    if math.dist(point, body.position) > 1e-12 * max(1.0, *map(abs, body.position)):
        yield f"{field} = {body.name!r} is a point mass at {body.position}, but it is attached at {point}"


def _attachment(part: Part, field: str) -> tuple[float, ...] | None:
    """Return where a part is attached to its body: the body's own mark, or the shared one."""
    own = (getattr(part, field.replace("body", kind), None) for kind in ("point", "center"))
    shared = (getattr(part, kind, None) for kind in ("point", "center"))
    return next((mark for mark in (*own, *shared) if mark is not None), None)


def _listing(names: Iterable[str], most: int = 12) -> str:
    shown = sorted(names)
    return f"the bodies are {', '.join(shown[:most])}{' ...' if len(shown) > most else ''}, and ground"
