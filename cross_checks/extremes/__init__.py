"""Extreme scenes along an axis from mild to hopeless: `extremes.toml` describes them, `families` makes them."""

import tomllib
from functools import cache
from importlib import import_module
from importlib.resources import files
from types import ModuleType
from typing import Any

from cross_checks import engines
from cross_checks.extremes.extreme import Axis, Extreme

DATA = tomllib.loads((files(__name__) / "extremes.toml").read_text(encoding="utf-8"))
LISTED, QUICK = DATA["extremes"], DATA["quick"]


@cache
def every() -> tuple[Extreme, ...]:
    """Return all extremes in the order of the file."""
    modules = {family: import_module(f"{__name__}.families.{family}") for family in LISTED}
    return tuple(_described(modules[family], **entry) for family, entries in LISTED.items() for entry in entries)


def _described(module: ModuleType, *, name: str, family: str, title: str, axis: str, **of_axis: Any) -> Extreme:
    """Return an extreme; an axis of labels has their numbers for values."""
    numbers = {"values": list(map(float, range(len(of_axis.get("labels", ()))))), "unit": ""}
    fields = {key: value if key == "unit" else tuple(value) for key, value in (numbers | of_axis).items()}
    engine = getattr(module, "ENGINE", engines.get)
    return Extreme(name, family, title, Axis(axis, **fields), module.CASES[name], engine)


def named(name: str) -> Extreme:
    """Return the extreme of that name; ValueError lists what there is."""
    for extreme in every():
        if extreme.name == name:
            return extreme
    raise ValueError(f"extreme = {name!r} is unknown; allowed: {', '.join(e.name for e in every())}")
