"""A part that acts on bodies, and what makes no sense in a scene as a whole: names that clash, misplaced parts."""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, ClassVar

from mbs_ref.scene.base.part import EndName, Name, Part, Role, fields_of
from mbs_ref.scene.bodies import GROUND, Body, PointMass
from mbs_ref.scene.signals import AnySignal

NO_ORIENTATION = "and has no orientation; use a rigid body"
COORDINATES = {2: ("x", "y", "angle"), 3: ("x", "y", "z")}  # of a body, as drives and events name them
_PLACES = {2: "the plane", 3: "space"}


@cache
def _signal_fields(kind: type[Part]) -> tuple[str, ...]:
    """Return the fields of a kind of part that hold functions of time."""
    return tuple(name for name, field in kind.model_fields.items() if field.annotation == AnySignal)


@cache
def _mark_fields(kind: type[Part], end: str) -> tuple[str, ...]:
    """Return the fields of a kind of part that may hold its mark on the body that the field `end` names."""
    side = end.removeprefix("body")
    return tuple(name for name in ("point" + side, "center" + side, "point", "center") if name in kind.model_fields)


def coordinate_complaints(coordinate: str, dimension: int, instead: str = "") -> Iterator[str]:
    """Yield what keeps a scene of this dimension from having the coordinate; `instead` advises on the angle."""
    if coordinate not in COORDINATES[dimension]:
        yield f"coordinate = {coordinate!r} is for {_PLACES[5 - dimension]} alone{instead * (coordinate == 'angle')}"


class Attached(Part):
    """A named part that acts on bodies. Class attributes state the properties of its kind."""

    DIMENSIONS: ClassVar[tuple[int, ...]] = (2, 3)  # of the scenes that may contain it
    COUNTERPART: ClassVar[str] = ""  # the type that does the same in the other dimension
    TURNS: ClassVar[bool] = False  # whether it acts on its bodies' orientation

    type: Any  # every kind names its own
    name: Name

    @property
    def ends(self) -> tuple[str, str]:
        """The two bodies it acts between; one that has a single body acts from ground."""
        fields = vars(self)  # quicker than hasattr, for which a model raises an exception
        return (fields["body_a"], fields["body_b"]) if "body_a" in fields else (GROUND, fields.get("body", GROUND))

    @property
    def signals(self) -> list[AnySignal]:
        """Its functions of time."""
        return [getattr(self, field) for field in _signal_fields(type(self))]

    def mark(self, end: str) -> tuple[float, ...] | None:
        """Return the world point (m, t = 0) of its attachment to the body named in the field `end`, if it has one."""
        fields, mark = vars(self), None
        for name in _mark_fields(type(self), end):
            mark = fields[name] if mark is None else mark
        return mark

    def vectors(self) -> Iterator[tuple[str, tuple[float, ...]]]:
        """Yield the fields that hold world vectors of the scene's dimension."""
        for field in fields_of(type(self), Role.WORLD_VECTOR):
            if getattr(self, field) is not None:
                yield field, getattr(self, field)

    def complaints(self, dimension: int) -> Iterator[str]:
        """Yield what is invalid in a scene of this dimension, beyond `DIMENSIONS` and the vectors' lengths."""
        yield from ()

    def refuses_particle(self, end: str, dimension: int) -> str:
        """Return why the body named in the field `end` may not be a point mass; empty where it may."""
        return NO_ORIENTATION if self.TURNS else ""


class AttachedPair(Attached):
    """A part between two bodies, or a body and ground."""

    body_a: EndName
    body_b: EndName

    @property
    def marks(self) -> tuple[Any, Any]:
        """The points of its attachment to body a and to body b (m, world, t = 0)."""
        return self.mark("body_a"), self.mark("body_b")


MOST_LISTED = 12  # bodies that a complaint names
_AT_ITS_PLACE = 1e-12  # of the largest coordinate (at least 1 m): how far from a particle it may be attached


def complaints(
    dimension: int, gravity: tuple[float, ...], bodies: Sequence[Body], attached: Mapping[str, Sequence[Attached]]
) -> Iterator[str]:
    """Yield what makes no sense in a scene as a whole, in one pass; `attached` holds its other parts by their field."""
    if len(gravity) != dimension:
        yield f"gravity = {gravity} must have {dimension} components here"
    for k, body in enumerate(bodies):
        if len(body.position) != dimension or len(body.velocity) != dimension:
            yield f"bodies[{k}] ({body.name}): position and velocity need {dimension} components"
        if body.name == GROUND:
            yield f"bodies[{k}]: a body may not be named {GROUND!r}, which is reserved"
    by_name = {body.name: body for body in bodies}
    for kind, parts in (("bodies", bodies), *attached.items()):
        yield from _name_clashes(kind, [part.name for part in parts])
    for kind, parts in attached.items():
        for k, part in enumerate(parts):
            yield from (f"{kind}[{k}] ({part.name}): {text}" for text in _part_complaints(part, by_name, dimension))


def _name_clashes(kind: str, names: list[str]) -> Iterator[str]:
    first: dict[str, int] = {}
    for k, name in enumerate(names):
        if first.setdefault(name, k) != k:
            yield f"{kind}[{k}]: the name {name!r} is taken by {kind}[{first[name]}]; names must differ"


def _part_complaints(part: Attached, bodies: Mapping[str, Body], dimension: int) -> Iterator[str]:
    yield from _missing_bodies(part, bodies)
    misplaced = list(_dimension_complaints(part, dimension))
    yield from misplaced
    if not misplaced:
        yield from _particle_complaints(part, bodies, dimension)


def _missing_bodies(part: Attached, bodies: Mapping[str, Body]) -> Iterator[str]:
    ends = fields_of(type(part), Role.END)
    for field in (*fields_of(type(part), Role.BODY), *ends):
        name = getattr(part, field)
        if name not in bodies and not (field in ends and name == GROUND):
            shown, ground = sorted(bodies), ", and ground" if field in ends else ""
            listed = f"{', '.join(shown[:MOST_LISTED])}{' ...' if len(shown) > MOST_LISTED else ''}{ground}"
            yield f"{field} = {name!r} is no body of the scene; the bodies are {listed}"
    if len(ends) == 2 and part.ends[0] == part.ends[1]:
        yield f"body_a and body_b are both {part.ends[0]!r}; they must differ"


def _dimension_complaints(part: Attached, dimension: int) -> Iterator[str]:
    if dimension not in part.DIMENSIONS:
        hint = f"; use {part.COUNTERPART}" if part.COUNTERPART else ""
        own, here = _PLACES[5 - dimension], _PLACES[dimension]
        yield f"a {part.type} is for {own} alone, and this scene is in {here}{hint}"
        return
    yield from part.complaints(dimension)
    for field, value in part.vectors():
        if len(value) != dimension:
            yield f"{field} = {value} must have {dimension} components here"


def _particle_complaints(part: Attached, bodies: Mapping[str, Body], dimension: int) -> Iterator[str]:
    """Yield what a particle cannot bear: a torque, or an attachment away from its place."""
    for field in (*fields_of(type(part), Role.BODY), *fields_of(type(part), Role.END)):
        body = bodies.get(getattr(part, field))
        if not isinstance(body, PointMass) or len(body.position) != dimension:
            continue
        reason, point = part.refuses_particle(field, dimension), part.mark(field)
        if reason:
            yield f"{field} = {body.name!r} is a point mass {reason}"
        elif point and math.dist(point, body.position) > _AT_ITS_PLACE * max(1.0, *map(abs, body.position)):
            yield f"{field} = {body.name!r} is a point mass at {body.position}, but it is attached at {point}"
