"""Robot files as scenes, one adapter for each parser; and what these share: starts, refusals, joints' own forces."""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from pydantic import ValidationError

from mbs_ref.scene import GROUND, Bushing, Revolute, RotationDrive, Scene, TorsionSpring
from mbs_ref.scene.base.part import normals
from mbs_ref.scene.messages import suggest

RATE = ".rate"  # a start rate is given as joint.rate
TABLES = ("joints", "rates", "drives")  # of a start file
LONGEST = 48  # letters of a name: a scene allows 64, and a joint's spring and damper are named after it
LOCKED = "locked"  # the value of a joint that shall not move


class RobotError(ValueError):
    """A robot file cannot be a scene; the sentence names each element that stands in the way."""


class Robot(NamedTuple):
    """A scene, and what was assumed to make it."""

    scene: Scene
    assumed: tuple[str, ...]


class Axis(NamedTuple):
    """One freedom between two bodies at the start."""

    joint: str
    body_a: str
    body_b: str
    point: tuple[float, float, float]  # m
    along: tuple[float, float, float]  # direction
    slides: bool


def plain(name: str) -> str:
    """Return a name of a file as scenes allow names: without spaces and slashes, a letter first, none of ground's."""
    plain = re.sub(r"[^A-Za-z0-9_.\-]", "_", name)[:LONGEST]
    plain = plain if re.match(r"[A-Za-z]", plain) else f"n{plain}"[:LONGEST]
    return f"{plain}_" if plain == GROUND else plain


def read_start(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what a start file asks for, as `-p` would, and the motions of the joints that are driven.

    Its tables are [joints] (rad, m, or "locked"), [rates] (rad/s, m/s) and [drives.JOINT] (a signal, as in a scene);
    what stands above them are the reader's options. RobotError where it cannot be read or holds another table.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise RobotError(f"{path}: cannot be read: {error}") from error
    tables = {name: value for name, value in content.items() if isinstance(value, dict)}
    refuse(path, (f"[{name}] is no table here; allowed: {', '.join(TABLES)}" for name in tables if name not in TABLES))
    given = {name: value for name, value in content.items() if name not in tables} | tables.get("joints", {})
    return given | {f"{name}{RATE}": value for name, value in tables.get("rates", {}).items()}, tables.get("drives", {})


def driven(scene: Scene, drives: Mapping[str, Any], path: Path) -> Scene:
    """Return the scene with motions of hinges prescribed; RobotError names a joint that is no hinge."""
    hinges = {joint.name: joint for joint in scene.joints if isinstance(joint, Revolute)}
    given = {plain(name): motion for name, motion in drives.items()}
    strange = [f"[drives.{name}] is of no hinge{suggest(name, hinges)}" for name in given if name not in hinges]
    refuse(path, [*strange, f"hinges are {', '.join(hinges)}"] if strange else [])
    with of_file(path):
        added = [RotationDrive.model_validate(_drive(hinges[name], motion)) for name, motion in given.items()]
        return Scene(**{**dict(scene), "joints": (*scene.joints, *added)})


def _drive(hinge: Revolute, motion: Mapping[str, Any]) -> dict[str, Any]:
    ends = {"body_a": hinge.body_a, "body_b": hinge.body_b, "axis": hinge.axis}
    level = {"level": motion["level"]} if "level" in motion else {}
    signal = {key: value for key, value in motion.items() if key != "level"}
    return {"name": f"{hinge.name}_drive", **ends, "motion": signal, **level}


def root_of(path: Path, *formats: str) -> ElementTree.Element:
    """Return the root element of a file; RobotError where it is no XML, or the root has none of the names."""
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise RobotError(f"{path}: cannot be read as XML: {error}") from error
    if root.tag not in formats:
        raise RobotError(f"{path}: its root is <{root.tag}>; expected: {' or '.join(f'<{name}>' for name in formats)}")
    return root


def base_of(path: Path) -> str:
    """Return the link of a URDF file that no joint carries."""
    robot = ElementTree.parse(path).getroot()
    carried = {child.get("link") for child in robot.iter("child")}
    return next(str(link.get("name")) for link in robot.findall("link") if link.get("name") not in carried)


def refuse(path: Path, reasons: Iterable[str]) -> None:
    """Raise RobotError where there is a reason."""
    if given := list(reasons):
        raise RobotError(f"{path}: {'; '.join(given)}")


def unknown(name: str, joints: list[str], options: str) -> str:
    """Return the sentence about a name that no joint has; `options` are the other names."""
    hint = suggest(name, joints)
    allowed = f"{options}, {', '.join(joints)}, each joint also as NAME{RATE}"
    return f"-p {name}: no joint has that name{hint}; allowed: {allowed}"


@contextmanager
def of_file(path: Path) -> Iterator[None]:
    """Turn what a part of a scene complains of into a RobotError about the file."""
    try:
        yield
    except ValidationError as error:
        problems = (f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
        raise RobotError(f"{path}: {'; '.join(problems)}") from error


def own_forces(axis: Axis, stiffness: float, damping: float, rest: float = 0.0) -> Iterator[TorsionSpring | Bushing]:
    """Yield the spring and damper of a joint's freedom, if any; `rest` is counted from the start (rad).

    A slide's spring is relaxed at the start.
    """
    if not (stiffness or damping):
        return
    name, a, b = f"{axis.joint}_{'spring' if stiffness else 'damping'}", axis.body_a, axis.body_b
    if not axis.slides:
        zero = rest if stiffness else None
        yield TorsionSpring(name=name, body_a=a, body_b=b, stiffness=stiffness, damping=damping, axis=axis.along,
                            rest_angle=zero)  # fmt: skip
        return
    yield Bushing(
        name=name, body_a=a, body_b=b, point=axis.point, x_axis=axis.along, y_axis=three(normals(axis.along)[0]),
        stiffness=(stiffness, 0.0, 0.0, 0.0, 0.0, 0.0), damping=(damping, 0.0, 0.0, 0.0, 0.0, 0.0),
    )  # fmt: skip


def three(vector: Any) -> tuple[float, float, float]:
    """Return three floats."""
    x, y, z = (float(value) for value in vector)
    return x, y, z


def six(m: np.ndarray) -> tuple[float, float, float, float, float, float]:
    """Return xx, yy, zz, xy, xz, yz of a symmetric matrix (3, 3)."""
    return tuple(float(m[r, c]) for r, c in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))  # pyright: ignore
