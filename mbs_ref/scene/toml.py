"""Read and write scenes as TOML files, and report every error. A scene file is data; nothing in it runs."""

import tomllib
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import ValidationError

from mbs_ref.atomic_file import write_atomic
from mbs_ref.scene.base.part import Part
from mbs_ref.scene.loads import UserForce
from mbs_ref.scene.messages import Problem, problems
from mbs_ref.scene.scene import Scene
from mbs_ref.scene.traits import python_parts

LARGEST_FILE = 32 * 2**20  # bytes; 100 000 bodies with their joints take about 25 MiB
USER_FORCE: str = UserForce.model_fields["type"].default


class SceneFileError(ValueError):
    """A scene file that cannot be read or written: `file`, and a `Problem` for each thing wrong with it."""

    def __init__(self, file: str, listed: list[Problem]) -> None:
        self.file = file
        self.problems = tuple(listed)
        super().__init__("\n".join(f"{file}: {problem}" for problem in listed))


def read_scene(path: str | Path) -> Scene:
    """Return the scene in a TOML file; SceneFileError lists every problem."""
    try:
        with Path(path).open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise _refusal(path, f"cannot be read: {error.strerror}") from error
    if len(content) > LARGEST_FILE:
        raise _refusal(path, f"is larger than {LARGEST_FILE // 2**20} MiB, the most a scene file may hold")
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise _refusal(path, f"is not UTF-8 text (byte {error.start})") from error
    return loads(text, file=str(path))


def loads(text: str, file: str = "scene") -> Scene:
    """Return the scene in a TOML text; errors refer to it as `file`."""
    try:
        data = _tuples(tomllib.loads(text))
    except RecursionError as error:
        raise _refusal(file, "is nested too deeply") from error
    except ValueError as error:  # TOMLDecodeError, or a number with more digits than Python converts
        raise _refusal(file, f"is not TOML: {error}") from error
    forbidden = _user_forces(data)
    if forbidden:
        raise SceneFileError(file, forbidden)
    try:
        return Scene.model_validate(data, strict=True)  # strict: mass = true is no number
    except ValidationError as error:
        raise SceneFileError(file, problems(error, Scene, data)) from error


def write_scene(scene: Scene, path: str | Path) -> None:
    """Write the scene as TOML, whole or not at all; SceneFileError where it cannot."""
    content = dumps(scene, file=str(path)).encode("utf-8")
    if len(content) > LARGEST_FILE:
        raise _refusal(path, f"would be larger than {LARGEST_FILE // 2**20} MiB, the most a scene file may hold")
    try:
        write_atomic(path, content)
    except OSError as error:
        raise _refusal(path, f"cannot be written: {error.strerror}") from error


def dumps(scene: Scene, file: str = "scene") -> str:
    """Return the scene as TOML without what is default; `loads` gives an equal scene back."""
    unwritable = [
        Problem(place, name, "", "is the user's own Python function, which a scene file cannot hold")
        for place, name in python_parts(scene)
    ]
    if unwritable:
        raise SceneFileError(file, unwritable)
    return tomli_w.dumps(_plain(scene))


def _plain(part: Part) -> dict[str, Any]:
    """Return the fields that differ from their defaults; the type always, because it distinguishes parts."""
    result: dict[str, Any] = {}
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        if name == "type" or field.is_required() or repr(value) != repr(field.default):  # repr keeps -0.0
            result[name] = _plain_value(value)
    return result


def _plain_value(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain_value(item) for item in value]
    return _plain(value) if isinstance(value, Part) else value


def _tuples(value: Any) -> Any:
    """Return TOML data with its lists as tuples, which is what a strict scene takes."""
    if isinstance(value, dict):
        return {key: _tuples(item) for key, item in value.items()}
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value


def _user_forces(data: dict[str, Any]) -> list[Problem]:
    loads = data.get("loads")
    return [
        Problem(f"loads[{k}].type", str(load.get("name", "")), repr(USER_FORCE), "cannot be in a file: it is Python")
        for k, load in enumerate(loads if isinstance(loads, tuple) else ())
        if isinstance(load, dict) and load.get("type") == USER_FORCE
    ]


def _refusal(path: str | Path, message: str) -> SceneFileError:
    return SceneFileError(str(path), [Problem("", "", "", message)])
