"""What the columns of a tool's file mean: every unit, axis and convention is stated, and none is guessed."""

import re
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from cross_checks.trajectory_files import columns as units
from cross_checks.trajectory_files.formats import FileError
from mbs_ref.files import package_data
from mbs_ref.trajectory import POSES, WORLDS

OWN = package_data(__name__, "own_map.toml")  # plane or space -> part
AXIS = re.compile(r"-?[xyz]")
EULER = re.compile(r"euler ([XYZ]{3}|[xyz]{3})")
CONVENTIONS = (
    "angle (in the plane), quaternion wxyz, quaternion xyzw, matrix (row by row), "
    "euler ZYX (about turning axes, in any order), euler zyx (about fixed axes)"
)


def _unit_of(kind: str) -> AfterValidator:
    def checked(unit: str) -> str:
        units.factor(kind, unit)
        return unit

    return AfterValidator(checked)


def _convention(text: str) -> str:
    if text in ("angle", "quaternion wxyz", "quaternion xyzw", "matrix") or EULER.fullmatch(text):
        return text
    raise ValueError(f"convention = {text!r} is unknown; allowed: {CONVENTIONS}")


def _axes(axes: tuple[str, ...]) -> tuple[str, ...]:
    if all(AXIS.fullmatch(axis) for axis in axes) and sorted(axis[-1] for axis in axes) == sorted("xyz"[: len(axes)]):
        return axes
    raise ValueError(f"axes = {list(axes)} must name each of x, y, z once, with a sign where it is turned round")


class Stated(BaseModel):
    """What a map holds; a word that it does not know is a mistake."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Time(Stated):
    column: str
    unit: Annotated[str, _unit_of("time")]


class Turned(Stated):
    """How far the file's world is turned about an axis of the scene besides: a column, as of a longitude."""

    column: str
    unit: Annotated[str, _unit_of("angle")]
    about: Literal["x", "y", "z"] = "z"


class World(Stated):
    """The file's world: which of its axes each axis of the scene is, and where its origin lies in the scene.

    A world that turns (space), as Earth-fixed axes do, is so at t = 0. Velocities are then those that are seen in it;
    angular velocities are counted against the scene's axes in any case.
    """

    axes: Annotated[tuple[str, ...], AfterValidator(_axes)] = ("x", "y", "z")
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)  # m
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)  # rad/s, along the scene's axes
    turned: Turned | None = None


class Position(Stated):
    """Of the centre of mass, in the file's world."""

    columns: tuple[str, ...]
    unit: Annotated[str, _unit_of("length")]


class Orientation(Stated):
    columns: tuple[str, ...]
    convention: Annotated[str, AfterValidator(_convention)]
    unit: Annotated[str, _unit_of("angle")] | None = None  # of angles
    maps: Literal["body to world", "world to body"] | None = None  # in space


class Velocity(Stated):
    """Of the centre of mass, in the file's world."""

    columns: tuple[str, ...]
    unit: Annotated[str, _unit_of("velocity")]


class AngularVelocity(Stated):
    columns: tuple[str, ...]
    unit: Annotated[str, _unit_of("angular velocity")]
    axes: Literal["world", "body"] | None = None  # in space


class Body(Stated):
    """What the file states of one body."""

    position: Position | None = None
    orientation: Orientation | None = None
    velocity: Velocity | None = None
    angular_velocity: AngularVelocity | None = None

    @property
    def missing(self) -> list[str]:
        """Which parts the file does not state."""
        return [part.replace("_", " ") for part in POSES if getattr(self, part) is None]


class ColumnMap(Stated):
    """The whole map; bodies that it leaves out are not judged."""

    time: Time
    bodies: dict[str, Body] = Field(min_length=1)
    world: World = World()
    delimiter: str = Field("", max_length=1)


def read_map(path: Path) -> ColumnMap:
    """Read a map from TOML; FileError lists every mistake with its place and what is allowed."""
    try:
        return ColumnMap.model_validate(tomllib.loads(path.read_text()))
    except OSError as error:
        raise FileError(f"{path}: cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileError(f"{path}: is no TOML: {error}") from error
    except ValidationError as error:
        places = (f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
        raise FileError(f"{path}: {'; '.join(places).replace('Value error, ', '')}") from error


def own_map(header: list[str], bodies: list[str]) -> ColumnMap | None:
    """Return the map of columns named as `mbs-ref simulate -o` names them, all or whole parts; None of others."""
    for world in OWN:
        stated = {
            body: {name: own for name, own in _named(world, f"{body}.{{}}").items() if {*own["columns"]} <= {*header}}
            for body in bodies
        }
        used = {column for parts in stated.values() for part in parts.values() for column in part["columns"]}
        if used and set(header) == {"t", *used}:
            return ColumnMap.model_validate({"time": {"column": "t", "unit": "s"}, "bodies": stated})
    return None


def _named(world: str, form: str) -> dict[str, Any]:
    """Return what a body's columns mean, by part, with a form of their names."""
    return {part: own | {"columns": [form.format(name) for name in own["columns"]]} for part, own in OWN[world].items()}


def blank_map(columns: list[str], bodies: list[str], dimension: int) -> str:
    """Return a map in TOML to be filled in: every statement that is needed, and the names that the file has."""
    head = (
        "# What the columns mean. Leave out what the file does not state; check every unit and convention.\n"
        f"# The file's columns: {', '.join(columns)}\n# Conventions of an orientation: {CONVENTIONS}\n"
    )
    parts = _named(WORLDS[dimension].name, "{}?")
    text = tomli_w.dumps({"time": {"column": "t?", "unit": "s"}, "bodies": dict.fromkeys(bodies, parts)})
    return head + re.sub(r"\[\n([^\]]+),\n\]", lambda names: f"[{' '.join(names[1].split())}]", text)
