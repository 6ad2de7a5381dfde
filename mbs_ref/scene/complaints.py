"""What makes no sense in a scene as a whole: names that clash or are missing, parts in the wrong dimension."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from mbs_ref.scene.bodies import GROUND, Body, PointMass
from mbs_ref.scene.celestial import CELESTIAL_TYPES
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, PinOnSprocket, SphereOnPlane, SphereOnSphere
from mbs_ref.scene.joints import (
    CoordinateDrive,
    Cylindrical,
    PointOnPlane,
    Revolute,
    RotationDrive,
    Spherical,
    Universal,
)
from mbs_ref.scene.loads import Bushing, PointBushing, Torque, TorqueVector, TorsionSpring
from mbs_ref.scene.part import Part

if TYPE_CHECKING:
    from mbs_ref.scene import Scene

_PLANAR_PARTS = (Torque, PointBushing, CircleOnLine, CircleOnCircle, PinOnSprocket)
_SPATIAL_PARTS = (
    Spherical, Universal, Cylindrical, PointOnPlane, RotationDrive, TorqueVector, Bushing, SphereOnPlane, SphereOnSphere
)  # fmt: skip
_HINTS = {
    "spherical": "; use revolute", "torque_vector": "; use torque", "torque": "; use torque_vector",
    "circle_on_line": "; use sphere_on_plane", "circle_on_circle": "; use sphere_on_sphere",
    "sphere_on_plane": "; use circle_on_line", "sphere_on_sphere": "; use circle_on_circle",
}  # fmt: skip
_TURNING_PARTS = {
    "prismatic", "weld", "torque", "torsion_spring", "universal", "cylindrical", "rotation_drive", "torque_vector",
    "bushing",
}  # fmt: skip
_VECTORS = (
    "point", "point_a", "point_b", "axis", "direction", "vector",
    "center", "center_a", "center_b", "point_1", "point_2", "axle",
)  # fmt: skip
_SHAPED_PARTS = ("circle_on_line", "pin_on_sprocket", "sphere_on_plane")  # their body_b carries more than a circle


def complaints(scene: Scene) -> Iterator[str]:
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


def _particle_complaints(part: Any, field: str, body: Body) -> Iterator[str]:
    """Yield what a particle cannot bear: a torque, or an attachment away from its place."""
    turning = part.type in _TURNING_PARTS or (isinstance(part, Revolute) and len(body.position) == 3)
    if turning or getattr(part, "coordinate", None) == "angle":
        yield f"{field} = {body.name!r} is a point mass and has no orientation; use a rigid body"
        return
    if field == "body_a" and part.type == "point_bushing":
        yield f"{field} = {body.name!r} is a point mass and cannot bear the bushing's couple; let it be body_b"
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
