"""Read and write scenes as TOML files, and report every error. A scene file is data; nothing in it runs."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from inspect import Parameter, Signature
from itertools import takewhile
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import ValidationError

from mbs_ref.files import write_atomic
from mbs_ref.scene.base.part import Part
from mbs_ref.scene.loads import UserForce
from mbs_ref.scene.messages import Problem, problems
from mbs_ref.scene.parameters import VALUES, Declared, filled
from mbs_ref.scene.scene import Scene
from mbs_ref.scene.traits import python_parts

LARGEST_FILE = 32 * 2**20  # bytes; 100 000 bodies with their joints take about 25 MiB
PARAMETER = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
FREE = ("description", "source", "parameters")  # may hold any text in a file that names no number
USER_FORCE: str = UserForce.model_fields["type"].default


class SceneFileError(ValueError):
    """A scene file that cannot be read or written: `file`, and a `Problem` for each thing wrong with it."""

    def __init__(self, file: str, listed: list[Problem]) -> None:
        self.file = file
        self.problems = tuple(listed)
        super().__init__("\n".join(f"{file}: {problem}" for problem in listed))


def read_scene(path: str | Path) -> Scene:
    """Return the scene in a TOML file; SceneFileError lists every problem."""
    return read_builder(path)()


def read_builder(path: str | Path) -> Callable[..., Scene]:
    """Return what builds the scene in a TOML file from the parameters that it declares (`builder`)."""
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
    return builder(text, file=str(path))


def loads(text: str, file: str = "scene") -> Scene:
    """Return the scene in a TOML text; errors refer to it as `file`."""
    return builder(text, file)()


def builder(text: str, file: str = "scene") -> Callable[..., Scene]:
    """Return what builds the scene in a TOML text; errors refer to it as `file`.

    Its parameters are those that the text declares, with their defaults and what is allowed in their annotations; the
    comments at the head of the text describe it.
    """
    try:
        data = _tuples(tomllib.loads(text))
    except RecursionError as error:
        raise _refusal(file, "is nested too deeply") from error
    except ValueError as error:  # TOMLDecodeError, or a number with more digits than Python converts
        raise _refusal(file, f"is not TOML: {error}") from error
    declared = [_declared(name, value, file) for name, value in _declarations(data).items()]
    signature = Signature(declared)
    plain = {} if declared or VALUES in data else {key: data[key] for key in FREE if key in data}
    formulas = {key: value for key, value in data.items() if key not in plain}

    def build(**given: Any) -> Scene:
        values = {parameter.name: parameter.default for parameter in declared} | signature.bind(**given).arguments
        try:
            built = filled(formulas, values, lambda *mistake: _refusal(file, *mistake)) | plain
        except RecursionError as error:
            raise _refusal(file, "is nested too deeply") from error
        return _validated(built, file)

    build.__signature__ = signature  # type: ignore[attr-defined]
    build.__annotations__ = {one.name: one.annotation for one in declared} | {"return": Scene}
    build.__doc__ = "\n".join(line[2:] for line in takewhile(lambda line: line[:1] == "#", text.splitlines()))
    return build


def _declarations(data: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters that are declared; plain values alone are those that a scene was built with."""
    found = data.get("parameters")
    return found if isinstance(found, dict) and any(isinstance(value, dict) for value in found.values()) else {}


def _declared(name: str, value: dict[str, Any], file: str) -> Parameter:
    place = f"parameters.{name}"
    if not PARAMETER.fullmatch(name):
        raise _refusal(file, place, "the name of a parameter consists of a letter, then letters, digits and _")
    try:
        return Declared.model_validate(value, strict=True).parameter(name)
    except ValidationError as error:
        listed = problems(error, Declared, value)
        raise SceneFileError(file, [replace(one, path=f"{place}.{one.path}".rstrip(".")) for one in listed]) from error


def _validated(data: dict[str, Any], file: str) -> Scene:
    loads = data.get("loads")
    forbidden = [
        Problem(f"loads[{k}].type", str(load.get("name", "")), repr(USER_FORCE), "cannot be in a file: it is Python")
        for k, load in enumerate(loads if isinstance(loads, tuple) else ())
        if isinstance(load, dict) and load.get("type") == USER_FORCE
    ]
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


def _refusal(path: str | Path, *mistake: str) -> SceneFileError:
    *place, message = mistake
    return SceneFileError(str(path), [Problem("".join(place), "", "", message)])
