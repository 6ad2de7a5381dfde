"""The scenes of the project: public functions of this folder's modules that return a Scene, and files in `data/`."""

import importlib
import inspect
import math
import pkgutil
import typing
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError, create_model

from mbs_ref.files import package_data
from mbs_ref.scene import Scene
from mbs_ref.scene import toml as scene_file
from mbs_ref.scene.base.part import OnlyWith
from mbs_ref.scene.messages import suggest

DATA = files(__name__) / "data"
OF_EVERY_SCENE = ("duration", "start")  # parameters that a scene need not declare
Parameter = float | int | str | bool


def read_data(name: str) -> dict[str, Any]:
    """Return mbs_ref/scenes/data/<name>.json: the numbers of a scene that has parameters."""
    return package_data(__name__, "data", f"{name}.json")


@dataclass(frozen=True)
class SceneInfo:
    """The summary and the parameters of a scene."""

    name: str
    summary: str  # first line of the builder's docstring
    parameters: dict[str, Parameter]  # name -> default


def names() -> list[str]:
    """Return the names of every scene, sorted."""
    return sorted((*_functions(), *_files()))


@cache
def _files() -> dict[str, Traversable]:
    return {path.name[:-5]: path for path in DATA.iterdir() if path.name.endswith(".toml")}


@cache
def _functions() -> dict[str, Callable[..., Scene]]:
    modules = [importlib.import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)]
    own = [
        (name, item)
        for module in modules
        for name, item in vars(module).items()
        if inspect.isfunction(item) and item.__module__ == module.__name__ and name[0] != "_"
    ]
    return {name: item for name, item in own if item.__annotations__.get("return") in (Scene, "Scene")}


@cache
def describe(name: str) -> SceneInfo:
    """Return the scene's summary and parameters; ValueError for an unknown scene."""
    builder = builder_of(name)
    return SceneInfo(name, (inspect.getdoc(builder) or "").splitlines()[0], _defaults(builder))


def _defaults(builder: Callable[..., Scene]) -> dict[str, Parameter]:
    return {p.name: p.default for p in inspect.signature(builder).parameters.values()}


def make(name: str, **parameters: Any) -> Scene:
    """Build a scene; ValueError names an unknown or invalid parameter, and the allowed ones.

    A parameter that the others exclude is refused even where its value is the default.
    Every scene has the parameters duration (s) and start = "equilibrium", which places it at rest in a static
    equilibrium near its start (`at_equilibrium`).
    """
    return build(builder_of(name), name, **parameters)


def build(builder: Callable[..., Scene], name: str, /, **parameters: Any) -> Scene:
    """Build a scene, as `make` does, by a builder such as `mbs_ref.scene.toml.read_builder` returns; errors name it."""
    for key, changed in zip(OF_EVERY_SCENE, (_lasting, _settled), strict=True):
        if key in parameters and key not in _defaults(builder):
            return changed(builder, name, **parameters)
    try:
        values = _parameter_model(builder)(**parameters).model_dump()
    except ValidationError as error:
        raise ValueError("; ".join(_sentence(builder, name, item) for item in error.errors())) from None
    chosen = _applicable(builder, values)
    for key in parameters.keys() - chosen.keys():
        other, needed = _marks(builder)[key]
        stated = f"{name}: {key} = {parameters[key]!r} does not go with {other} = {values[other]!r}"
        raise ValueError(f"{stated}: it belongs to {other} = {needed!r}")
    built = builder(**chosen)
    return built.model_copy(update={"parameters": chosen}) if chosen else built


def applicable(name: str, parameters: dict[str, Any]) -> dict[str, Any]:
    """Return those of a scene's parameters that the others do not exclude."""
    return _applicable(builder_of(name), parameters)


def _applicable(builder: Callable[..., Scene], parameters: dict[str, Any]) -> dict[str, Any]:
    excluded = {key for key, (other, needed) in _marks(builder).items() if parameters[other] != needed}
    return {key: value for key, value in parameters.items() if key not in excluded}


def _marks(builder: Callable[..., Scene]) -> dict[str, OnlyWith]:
    """Return by parameter which other value it belongs to."""
    fields = _parameter_model(builder).model_fields
    return {key: mark for key, field in fields.items() for mark in field.metadata if isinstance(mark, OnlyWith)}


def _lasting(builder: Callable[..., Scene], name: str, /, duration: float, **parameters: Any) -> Scene:
    """Return a scene of another duration (s), where its own builder has no such parameter."""
    if isinstance(duration, bool | str) or not 0.0 < duration < math.inf:
        raise ValueError(f"{name}: duration = {duration!r} is not allowed: it must be a finite number greater than 0")
    return _altered(build(builder, name, **parameters), {"duration": float(duration)}, duration=duration)


def _altered(scene: Scene, fields: dict[str, Any], **parameters: Any) -> Scene:
    """Return the scene with other fields and with further parameters."""
    return scene.model_copy(update={**fields, "parameters": {**scene.parameters, **parameters}})


def _settled(builder: Callable[..., Scene], name: str, /, start: str, **parameters: Any) -> Scene:
    """Return a scene in equilibrium, where its own builder has no such choice."""
    if start != "equilibrium":
        raise ValueError(f"{name}: start = {start!r} is not allowed; allowed: 'equilibrium'")
    from mbs_ref.simulate.equilibrium import at_equilibrium  # compiled code, which other scenes do without

    return _altered(at_equilibrium(build(builder, name, **parameters)), {}, start=start)


def label(name: str, parameters: dict[str, Any]) -> str:
    """Return a scene's name, counts and other non-default parameters, in the syntax of the command line."""
    counts = {key: value for key, value in parameters.items() if type(value) is int}
    return " ".join([name, *(f"{key}={value}" for key, value in (counts | chosen(name, parameters)).items())])


def chosen(name: str, parameters: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters that differ from the defaults; all of them for other scenes than these."""
    defaults = describe(name).parameters if name in _functions() or name in _files() else {}
    return {key: value for key, value in parameters.items() if defaults.get(key) != value}


@cache
def builder_of(name: str) -> Callable[..., Scene]:
    """Return what builds a scene of any parameters, also of such as `make` refuses; ValueError for an unknown scene."""
    if name in _files():
        return scene_file.builder(_files()[name].read_text(encoding="utf-8"), f"{name}.toml")
    if name not in _functions():
        raise ValueError(f"scene = {name!r} is unknown{suggest(name, names())}; the scenes are {', '.join(names())}")
    return _functions()[name]


@cache
def _parameter_model(builder: Callable[..., Scene]) -> type[BaseModel]:
    """Return the builder's signature as a pydantic model, whose annotations are the ranges."""
    hints = typing.get_type_hints(builder, include_extras=True)
    parameters = inspect.signature(builder).parameters.values()
    fields: dict[str, Any] = {p.name: (hints[p.name], p.default) for p in parameters}
    return create_model("Parameters", __config__=ConfigDict(extra="forbid", allow_inf_nan=False), **fields)


def _sentence(builder: Callable[..., Scene], scene: str, item: Any) -> str:
    """Return a sentence on one invalid parameter of a scene."""
    name = ".".join(str(part) for part in item["loc"])
    if item["type"] == "extra_forbidden":
        allowed = _defaults(builder)
        stated = f"{name} = {item['input']!r} is no parameter of {scene}"
        return f"{stated}{suggest(name, allowed)}; allowed: {', '.join(allowed)}"
    return f"{scene}: {name} = {item['input']!r} is not allowed: {item['msg'].lower()}"
