"""What makes no sense in a scene as a whole: names that clash or are missing, parts in the wrong dimension."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from mbs_ref.scene.base.attached import Attached
from mbs_ref.scene.base.part import Role, fields_of
from mbs_ref.scene.bodies import GROUND, Body, PointMass

_PLACES = {2: "the plane", 3: "space"}
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
            yield f"{field} = {name!r} is no body of the scene; {_listing(bodies, ground=field in ends)}"
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


def _listing(names: Iterable[str], ground: bool, most: int = 12) -> str:
    shown = sorted(names)
    listed = f"the bodies are {', '.join(shown[:most])}{' ...' if len(shown) > most else ''}"
    return f"{listed}, and ground" if ground else listed
