"""Extreme scenes along an axis from mild to hopeless: `extremes.toml` describes them, `families` makes them."""

import tomllib
from functools import cache
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from types import ModuleType
from typing import Any

from cross_checks import engines
from cross_checks.extremes.extreme import Axis, Extreme

DATA = tomllib.loads((files(__name__) / "extremes.toml").read_text(encoding="utf-8"))
LISTED, QUICK = DATA["extremes"], DATA["quick"]
MAP = Path(str(files(__name__))) / "data" / "map.jsonl"  # the cells of the last run over all families


@cache
def every() -> tuple[Extreme, ...]:
    """Return all extremes in the order of the file."""
    modules = {family: import_module(f"{__name__}.families.{family}") for family in LISTED}
    return tuple(_described(modules[family], entry) for family, entries in LISTED.items() for entry in entries)


def _described(module: ModuleType, entry: dict[str, Any]) -> Extreme:
    """Return an extreme; an axis of labels has their numbers for values."""
    labels, full, name = tuple(entry.get("labels", ())), tuple(entry.get("full", ())), entry["name"]
    values = tuple(entry.get("values", map(float, range(len(labels)))))
    axis = Axis(entry["axis"], entry.get("unit", ""), values, labels, full)
    return Extreme(
        name, entry["family"], entry["title"], axis, module.CASES[name], getattr(module, "ENGINE", engines.get)
    )


def named(name: str) -> Extreme:
    """Return the extreme of that name; ValueError lists what there is."""
    for extreme in every():
        if extreme.name == name:
            return extreme
    raise ValueError(f"extreme = {name!r} is unknown; allowed: {', '.join(e.name for e in every())}")
