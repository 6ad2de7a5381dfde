"""The numbers of a scene by name, as its TOML has them: `load.stiffness`, `ball.position.y`, `gravity.x`."""

from collections.abc import Iterator, Mapping, Sequence
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import Part, Role, fields_of
from mbs_ref.scene.messages import suggest

Place = tuple[str | int, ...]  # fields and places in lists, from the scene down to a number
LISTS = ("bodies", "joints", "loads", "contacts", "events")
LETTERS = ("x", "y", "z")
SIX = {"inertia": ("xx", "yy", "zz", "xy", "xz", "yz")}  # in space
EULER = "orientation"  # of norm 1, so that no entry varies alone; TURN varies it
TURN = "turn"  # rad, about the world's axes, from the scene's orientation
MAX_NAMED = 12  # names of parts in an error message


def place_of(scene: Scene, name: str) -> Place:
    """Return the place of a named number; ValueError names the unknown part or number, and those that exist."""
    owner, place = _owner(scene, name)
    known = {".".join(map(str, names)): path for names, path in _numbers(owner)}
    label = name.removeprefix(getattr(owner, "name", "") + ".") if place else name
    if label not in known:
        listed = ", ".join(known) or "none"
        raise ValueError(f"{name!r} is unknown{suggest(label, known)}; numbers of {owner.name!r}: {listed}")
    return (*place, *known[label])


def value_at(scene: Scene, place: Place) -> float | None:
    """Return the number at a place; None if the scene does not set it."""
    here: Any = scene
    if TURN in place:
        return 0.0
    for key in place:
        here = _item(here, key)
    return here


def _owner(scene: Scene, name: str) -> tuple[Any, Place]:
    """Return the part with which the name begins and its place; the scene itself for gravity."""
    if name.startswith("gravity."):
        return scene, ()
    parts = {part.name: (part, (kind, k)) for kind in LISTS for k, part in enumerate(getattr(scene, kind))}
    heads = [name[:k] for k in range(len(name), 0, -1) if name[k : k + 1] == "."]  # names may hold dots
    for head in heads:
        if head in parts:
            return parts[head]
    listed = ", ".join(list(parts)[:MAX_NAMED]) + (", ..." if len(parts) > MAX_NAMED else "")
    part = heads[0] if heads else name
    raise ValueError(f"{name!r} is unknown{suggest(part, parts)}; it begins with gravity or a part: {listed}")


def _numbers(part: Part) -> Iterator[tuple[Place, Place]]:
    """Yield the label and the place of every number of a part; of the scene those of gravity."""
    for name in ("gravity",) if isinstance(part, Scene) else type(part).model_fields:
        value, annotation = getattr(part, name), type(part).model_fields[name].annotation
        if isinstance(value, float) or (value is None and _may_be_number(annotation)):
            yield (name,), (name,)
        elif isinstance(value, Part):
            yield from (((name, *label), (name, *place)) for label, place in _numbers(value))
        elif name == EULER:
            yield from (((TURN, letter), (TURN, k)) for k, letter in enumerate(LETTERS))
        elif isinstance(value, tuple):
            labels = _components(type(part), name, len(value))
            yield from (((name, label), (name, k)) for k, label in enumerate(labels) if isinstance(value[k], float))


def _may_be_number(annotation: Any) -> bool:
    if get_origin(annotation) in (Union, UnionType, Annotated):
        return any(_may_be_number(one) for one in get_args(annotation))
    return annotation is float


def _components(kind: type[Part], name: str, count: int) -> Sequence[str | int]:
    """Return the names of a field's entries: letters in vectors, else their indices from 0."""
    of_any_length = Ellipsis in get_args(kind.model_fields[name].annotation)
    if count in (2, 3) and (name in fields_of(kind, Role.WORLD_VECTOR) or not of_any_length):
        return LETTERS[:count]
    return SIX[name] if name in SIX and count == 6 else range(count)


def with_values(here: Any, values: Mapping[Place, float]) -> Any:
    """Return a scene, or a part of one, with other numbers; pydantic's ValidationError if it is invalid."""
    below: dict[str | int, dict[Place, float]] = {}
    for place, value in values.items():
        below.setdefault(place[0], {})[place[1:]] = value
    changed = {key: inner[()] if () in inner else with_values(_item(here, key), inner) for key, inner in below.items()}
    if isinstance(here, tuple):
        return tuple(changed.get(k, item) for k, item in enumerate(here))
    return type(here)(**{name: changed.get(name, getattr(here, name)) for name in type(here).model_fields})


def _item(here: Any, key: str | int) -> Any:
    return getattr(here, key) if isinstance(key, str) else here[key]
