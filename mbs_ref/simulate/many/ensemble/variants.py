"""The scene and the start of every run: other numbers, parameters or initial conditions.

A scene's numbers have the names of its TOML: `load.stiffness`, `ball.position.y`, `gravity.x`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

import numpy as np
import scipy
from pydantic import ValidationError

from mbs_ref.cores.choice import compile_scene
from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene
from mbs_ref.scene.base.part import Part, Role, fields_of
from mbs_ref.scene.euler_parameters import product
from mbs_ref.scene.messages import sentences, suggest
from mbs_ref.simulate.start_checks import RATES, InconsistentScene, fitted_rates

Place = tuple[str | int, ...]  # fields and places in lists, from the scene down to a number
LISTS = ("bodies", "joints", "loads", "contacts", "events")
LETTERS = ("x", "y", "z")
SIX = {"inertia": ("xx", "yy", "zz", "xy", "xz", "yz")}  # in space
EULER = "orientation"  # of norm 1, so that no entry varies alone; TURN varies it
TURN = "turn"  # rad, about the world's axes, from the scene's orientation
MAX_NAMED = 12  # names of parts in an error message
# at t = 0: a body is moved together with the marks of joints, springs and contacts on it
POSE = ("position", "angle", TURN)
FIELDS = {"angle": "orientation"}  # of a body, as Poses has them


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


class Target(NamedTuple):
    """A varied number: a parameter of the scene, or a place in it."""

    name: str
    own: float | None
    place: Place | None

    @property
    def start(self) -> str:
        """The field of a body's start to which it belongs, or nothing."""
        if self.place is None or self.place[0] != "bodies":
            return ""
        field = str(self.place[2])
        return field if field in (*POSE, *RATES) else ""


@dataclass(frozen=True)
class Source:
    """The scene that is varied, and its builder for other parameters if it has one."""

    scene: Scene
    rebuild: Callable[..., Scene] | None = None

    def target(self, name: str) -> Target:
        """Return the number of a name; ValueError names what is unknown, and what exists."""
        parameters = self.scene.parameters if self.rebuild else {}
        if name in parameters:
            own = parameters[name]
            if isinstance(own, bool | str):
                raise ValueError(f"the parameter {name} = {own!r} is not a number, and cannot be varied")
            return Target(name, float(own), None)
        try:
            place = place_of(self.scene, name)
        except ValueError as error:
            listed = f"; parameters of {self.scene.name}: {', '.join(parameters)}" if parameters else ""
            hint = suggest(name, parameters) if "." not in name else ""
            raise ValueError(f"{error}{listed}{hint}") from None
        return Target(name, value_at(self.scene, place), place)


@dataclass(frozen=True)
class Variants:
    """The scene and the start of every run."""

    source: Source
    targets: Sequence[Target]
    fixed: tuple[str, ...] = ()  # velocities that do not change when the others are fitted to the joints
    tolerance: float = 1e-9  # m, rad, m/s, rad/s: largest violation of a joint then

    def __post_init__(self) -> None:
        moved = [target.name for target in self.targets if target.start in POSE]
        if self.fixed and moved:
            raise ValueError(
                f"keep = {', '.join(self.fixed)} fits velocities, but {', '.join(moved)} varies a pose; "
                "project the start instead (project_initial)"
            )
        if self.fixed:
            with suppress(InconsistentScene):  # of the unchanged scene; unknown names raise ValueError
                fitted_rates(self.source.scene, self.fixed, self.tolerance)

    @property
    def is_one_scene(self) -> bool:
        """Whether runs differ in their start alone."""
        return not self.fixed and all(target.start for target in self.targets)

    @property
    def moves(self) -> bool:
        """Whether runs differ in poses at t = 0."""
        return any(target.start in POSE for target in self.targets)

    def scene(self, values: np.ndarray) -> Scene:
        """Return a run's scene with its velocities, without the start's poses; ValueError if the scene is invalid."""
        pairs = list(zip(self.targets, values.tolist(), strict=True))
        given = {target.name: value for target, value in pairs if target.place is None}
        parameters: dict[str, Any] = {name: int(x) if x.is_integer() else x for name, x in given.items()}  # may count
        scene = self.source.rebuild(**parameters) if parameters and self.source.rebuild else self.source.scene
        if scene.body_names != self.source.scene.body_names:
            raise ValueError(f"{', '.join(parameters)} changes the number or names of bodies; vary another parameter")
        places = {t.place: value for t, value in pairs if t.place is not None and t.start not in POSE}
        try:
            scene = with_values(scene, places) if places else scene
        except ValidationError as error:
            raise ValueError(sentences(error, Scene, {})) from None
        return fitted_rates(scene, self.fixed, self.tolerance) if self.fixed else scene

    def start(self, scene: Scene, values: np.ndarray) -> Poses:
        """Return the poses and velocities (one sample of each) at the start of a run."""
        start = own_start(scene)
        _set(start, self.targets, values[None], POSE)
        return start

    def starts(self, values: np.ndarray) -> Poses:
        """Return the start of every run (n of each) of the one scene."""
        starts = Poses(*(np.repeat(part, len(values), axis=0) for part in own_start(self.source.scene)))
        _set(starts, self.targets, values, (*POSE, *RATES))
        return starts


def own_start(scene: Scene) -> Poses:
    """Return the poses and velocities of a scene at t = 0, one sample of each."""
    system = compile_scene(scene)
    return system.poses(system.initial_state()[None])


def _set(starts: Poses, targets: Sequence[Target], values: np.ndarray, fields: tuple[str, ...]) -> None:
    """Write the values (n, n_targets) of the targets with such a field into starts (n of each)."""
    turns: dict[int, np.ndarray] = {}  # rotation vectors (n, 3) of bodies in space, rad
    for target, column in zip(targets, values.T, strict=True):
        if target.start in fields and target.place is not None:
            _, body, field, *component = target.place
            if field == TURN:
                turns.setdefault(int(body), np.zeros((len(values), 3)))[:, int(component[0])] = column
            else:
                getattr(starts, FIELDS.get(str(field), str(field)))[(slice(None), body, *component)] = column
    for body, vectors in turns.items():
        turned = scipy.spatial.transform.Rotation.from_rotvec(vectors).as_quat(scalar_first=True)
        starts.orientation[:, body] = product(turned, starts.orientation[:, body])
