"""The language of scenes: bodies, joints, drives and loads, on two pages.

A scene is plain frozen data in SI units. Joints and attachment points are given as world points and
axes at t = 0. Traits (planar or spatial, closed loops, rheonomic terms) are computed, never typed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, SkipValidation, model_validator

from mbs_ref.celestial import CELESTIAL_TYPES, CelestialLoad
from mbs_ref.contact import CircleOnCircle, CircleOnLine, Contact, PinOnSprocket, SphereOnPlane, SphereOnSphere
from mbs_ref.part import Name, NonNegative, Part, Positive, Vector
from mbs_ref.scene_events import Event
from mbs_ref.signals import Constant, Level, Signal, breakpoints

GROUND = "ground"
MOST_COMPLAINTS = 100  # about one scene at once: each may list the bodies, and there may be 100 000


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


LARGEST_NORM_GAP = 1e-9  # of theta^T theta from 1: data with fewer digits are a mistake, or say so
SMALLEST_INERTIA_RATIO = 1e-9  # of the principal moments: below, double precision cannot hold the small one


def _six_numbers(value: Any) -> Any:
    """Turn a symmetric 3x3 matrix into xx, yy, zz, xy, xz, yz; leave everything else to be checked."""
    if not isinstance(value, list | tuple) or len(value) != 3 or not all(isinstance(r, list | tuple) for r in value):
        return value
    if any(len(row) != 3 for row in value) or any(value[r][c] != value[c][r] for r in range(3) for c in range(r)):
        raise ValueError(f"inertia = {value} is no symmetric 3x3 matrix")
    return (*(value[k][k] for k in range(3)), value[0][1], value[0][2], value[1][2])


Inertia = Annotated[tuple[float, float, float, float, float, float], BeforeValidator(_six_numbers)]
Vector3 = tuple[float, float, float]
SixNonNegative = tuple[NonNegative, NonNegative, NonNegative, NonNegative, NonNegative, NonNegative]


class SpatialBody(Part):
    """A rigid body in space, q = [R, theta0..theta3] with its Euler parameters (Fox 1999, appendix).

    theta0 = cos(angle / 2), (theta1, theta2, theta3) = axis sin(angle / 2), turning body axes into world axes.
    """

    type: Literal["spatial"] = "spatial"
    name: Name
    mass: Positive  # kg
    inertia: Inertia  # kg m^2, about the centre of mass, body axes: xx, yy, zz, xy, xz, yz, or the 3x3 matrix
    position: Vector3 = (0.0, 0.0, 0.0)  # m, centre of mass at t = 0
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)  # Euler parameters, of norm 1
    velocity: Vector3 = (0.0, 0.0, 0.0)  # m/s
    angular_velocity: Vector3 = (0.0, 0.0, 0.0)  # rad/s, world axes

    @model_validator(mode="after")
    def _check(self) -> Self:
        norm = math.hypot(*self.orientation)
        if not abs(norm * norm - 1.0) <= LARGEST_NORM_GAP:
            raise ValueError(f"orientation = {self.orientation} has the norm {norm:.12g}; Euler parameters have 1")
        _require_inertia(self.inertia)
        return self

    @property
    def inertia_matrix(self) -> np.ndarray:
        """The inertia (3, 3), kg m^2, body axes."""
        return symmetric(self.inertia)


def symmetric(six: tuple[float, ...]) -> np.ndarray:
    """Return the 3x3 matrix of xx, yy, zz, xy, xz, yz."""
    xx, yy, zz, xy, xz, yz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _require_inertia(inertia: tuple[float, ...]) -> None:
    low, middle, high = (float(x) for x in np.linalg.eigvalsh(symmetric(inertia)))
    moments = f"inertia has the principal moments {low:.3g}, {middle:.3g}, {high:.3g} kg m^2"
    if not low > SMALLEST_INERTIA_RATIO * high:
        raise ValueError(f"{moments}; the least must exceed {SMALLEST_INERTIA_RATIO:g} of the greatest")
    if not high <= (low + middle) * (1.0 + 1e-9):
        raise ValueError(f"{moments}; no body has one that exceeds the sum of the others")


Body = Annotated[PlanarBody | SpatialBody | PointMass, Field(discriminator="type")]


# --- joints ---------------------------------------------------------------------------------------


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
            _require_direction("axis", self.axis)
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
        _require_perpendicular("axis_a", self.axis_a, "axis_b", self.axis_b)
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
        _require_direction("axis", self.axis)
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
        _require_direction("normal", self.normal)
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
        _require_direction("axis", self.axis)
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
        _require_direction("direction", self.direction)
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
        _require_direction("axis", self.axis)
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
    """A torque on a planar body times a signal."""

    type: Literal["torque"] = "torque"
    name: Name
    body: Name
    torque: float  # N m
    factor: Signal = Constant()


class TorqueVector(Part):
    """A torque on a spatial body: vector times a signal, along fixed world or body axes."""

    type: Literal["torque_vector"] = "torque_vector"
    name: Name
    body: Name
    vector: Vector3  # N m
    frame: Literal["world", "body"] = "world"
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
    """A rotational spring and damper on the relative angle of two bodies.

    In space the angle is that of body b about `axis`, fixed in body a, counted from t = 0; it goes with a
    joint that keeps the axis. Beyond 3 rad either way a spatial spring stops the run: it cannot count turns.
    """

    type: Literal["torsion_spring"] = "torsion_spring"
    name: Name
    body_a: Name
    body_b: Name
    stiffness: NonNegative  # N m/rad
    damping: NonNegative = 0.0  # N m s/rad
    rest_angle: float | None = None  # rad, of b relative to a; the initial one unless given
    axis: Vector | None = None  # direction, world, t = 0; in space alone, and there it must be given


class Bushing(Part):
    """Six springs and dampers between two bodies at a point, along axes fixed in body a (space).

    Stiffness and damping are for the offset along x, y, z and the rotation vector about x, y, z of the
    bushing's axes; neither is strained at t = 0. Beyond 3 rad of relative rotation it stops the run.
    """

    type: Literal["bushing"] = "bushing"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector3  # m, world, t = 0
    stiffness: SixNonNegative  # N/m, N m/rad
    damping: SixNonNegative = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # N s/m, N m s/rad
    x_axis: Vector3 = (1.0, 0.0, 0.0)  # direction, world, t = 0
    y_axis: Vector3 = (0.0, 1.0, 0.0)  # direction, world, t = 0; perpendicular to x_axis

    @model_validator(mode="after")
    def _check(self) -> Self:
        _require_perpendicular("x_axis", self.x_axis, "y_axis", self.y_axis)
        return self


class PointBushing(Part):
    """An isotropic spring and damper between two marks that coincide at t = 0: F = k e + c de/dt, e their gap (plane).

    Both forces act at body b's mark, so no couple is left over: momentum is kept, and the damper only takes energy.
    """

    type: Literal["point_bushing"] = "point_bushing"
    name: Name
    body_a: Name
    body_b: Name
    point: Vector  # m, world, t = 0
    stiffness: NonNegative  # N/m
    damping: NonNegative = 0.0  # N s/m


class UserForce(Part):
    """A user's own force law, called as function(t, q, v) -> generalized forces.

    q, v and the result have shape (n_bodies, 3) in the scene's body order: m, m, rad; N, N, N m. In space
    q is (n_bodies, 7): m and Euler parameters, v and the result (n_bodies, 6): m/s, rad/s; N, N m, world axes,
    about the centre of mass. A Python function is slow and is reported as such. It does not write to TOML.
    """

    type: Literal["user_force"] = "user_force"
    name: Name
    function: Annotated[Callable[..., Any], SkipValidation]


Load = Annotated[
    Force | Torque | TorqueVector | SpringDamper | TorsionSpring | Bushing | PointBushing | UserForce | CelestialLoad,
    Field(discriminator="type"),
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
    events: tuple[Event, ...] = ()
    parameters: dict[str, float | int | str | bool] = {}  # what the scene was built with

    @model_validator(mode="after")
    def _check(self) -> Self:
        found = list(islice(_complaints(self), MOST_COMPLAINTS))
        if len(found) == MOST_COMPLAINTS:
            found.append("and perhaps more: no further complaints were looked for")
        if found:
            raise ValueError("\n".join(found))
        return self

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space: what the bodies are made of."""
        return max(len(b.position) for b in self.bodies)

    @property
    def body_names(self) -> list[str]:
        return [body.name for body in self.bodies]

    def body_index(self, name: str) -> int:
        """Return the body's place in `bodies`; -1 for ground."""
        return -1 if name == GROUND else self._places[name]

    @property
    def _places(self) -> dict[str, int]:
        """The places by name, kept while the bodies are the same tuple: a copy may have others."""
        kept: dict[str, Any] = vars(self)
        bodies, places = kept.get("_kept_places", (None, {}))
        if bodies is not self.bodies:
            places = {body.name: k for k, body in enumerate(self.bodies)}
            kept["_kept_places"] = (self.bodies, places)
        return places

    def breakpoints(self) -> list[float]:
        """Return the sorted times (s) at which a declared signal may be non-smooth."""
        signals = [load.factor for load in self.loads if isinstance(load, Force | Torque | TorqueVector)]
        signals += [j.motion for j in self.joints if isinstance(j, DRIVES)]
        return sorted({t for signal in signals for t in breakpoints(signal)})


def _require_direction(field: str, value: tuple[float, ...]) -> None:
    if not math.hypot(*value) > 0.0:  # neither overflows nor underflows
        raise ValueError(f"{field} = {value} has no direction; give any vector but zero")


def _require_perpendicular(name: str, first: Vector3, other_name: str, second: Vector3) -> None:
    _require_direction(name, first)
    _require_direction(other_name, second)
    cosine = math.sumprod(first, second) / math.hypot(*first) / math.hypot(*second)
    if not abs(cosine) <= 1e-9:
        pair = f"{name} = {first} and {other_name} = {second}"
        raise ValueError(f"{pair} must be perpendicular; their cosine is {cosine:.3g}")


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
    if dimension == 3 and scene.events:
        yield f"events[0] ({scene.events[0].name}): declared events are for the plane alone so far"
    bodies = {body.name: body for body in scene.bodies}
    attached = (
        ("joints", scene.joints), ("loads", scene.loads), ("contacts", scene.contacts), ("events", scene.events),
    )  # fmt: skip
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
    for field in ("body", "body_a", "body_b", "planet", "raiser"):
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
    if getattr(part, "type", "") in CELESTIAL_TYPES and dimension != 3:
        yield f"type = {getattr(part, 'type', '')!r} belongs to scenes in space; give positions three components"
    yield from _dimension_complaints(part, dimension)
    if _only_in(part) in (None, dimension):
        for field in _VECTORS:
            value = getattr(part, field, None)
            if value is not None and len(value) != dimension:
                yield f"{field} = {value} must have {dimension} components here"


_PLANAR_PARTS = (Torque, PointBushing, CircleOnLine, CircleOnCircle, PinOnSprocket)
_SPATIAL_PARTS = (
    Spherical, Universal, Cylindrical, PointOnPlane, RotationDrive, TorqueVector, Bushing, SphereOnPlane, SphereOnSphere
)  # fmt: skip
_HINTS = {
    "spherical": "; use revolute", "torque_vector": "; use torque", "torque": "; use torque_vector",
    "circle_on_line": "; use sphere_on_plane", "circle_on_circle": "; use sphere_on_sphere",
    "sphere_on_plane": "; use circle_on_line", "sphere_on_sphere": "; use circle_on_circle",
}  # fmt: skip


def _only_in(part: Part) -> int | None:
    return 2 if isinstance(part, _PLANAR_PARTS) else 3 if isinstance(part, _SPATIAL_PARTS) else None


def _dimension_complaints(part: Any, dimension: int) -> Iterator[str]:
    """Yield what makes sense in the plane alone, or in space alone."""
    place = {2: "the plane", 3: "space"}
    if _only_in(part) not in (None, dimension):
        own, other = place[5 - dimension], place[dimension]
        yield f"a {part.type} is for {own} alone, and this scene is in {other}{_HINTS.get(part.type, '')}"
    if isinstance(part, Revolute | TorsionSpring):
        if dimension == 3 and part.axis is None:
            yield f"a {part.type} in space needs an axis"
        if dimension == 2 and part.axis is not None:
            yield f"axis = {part.axis}: in the plane a {part.type} turns about the normal; leave the axis out"
    if isinstance(part, TorsionSpring) and part.axis is not None and not math.hypot(*part.axis) > 0.0:
        yield f"axis = {part.axis} has no direction; give any vector but zero"
    if isinstance(part, CoordinateDrive) and part.coordinate == {2: "z", 3: "angle"}[dimension]:
        hint = "; use rotation_drive" if dimension == 3 else ""
        yield f"coordinate = {part.coordinate!r} is for {place[5 - dimension]} alone{hint}"


_TURNING_PARTS = {
    "prismatic", "weld", "torque", "torsion_spring", "universal", "cylindrical", "rotation_drive", "torque_vector",
    "bushing",
}  # fmt: skip
_VECTORS = (
    "point", "point_a", "point_b", "axis", "direction", "vector",
    "center", "center_a", "center_b", "point_1", "point_2", "axle",
)  # fmt: skip
_SHAPED_PARTS = ("circle_on_line", "pin_on_sprocket", "sphere_on_plane")  # their body_b carries more than a circle


def _particle_complaints(part: Any, field: str, body: Body) -> Iterator[str]:
    """Yield what a particle cannot bear: a torque, or an attachment away from its place."""
    turning = part.type in _TURNING_PARTS or (isinstance(part, Revolute) and len(body.position) == 3)
    if turning or getattr(part, "coordinate", None) == "angle":
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
