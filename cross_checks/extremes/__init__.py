"""Extreme scenes along an axis from mild to hopeless: one file a family, found by listing `families`."""

import importlib
import pkgutil
from functools import cache

from cross_checks.extremes import families
from cross_checks.extremes.extreme import Extreme


@cache
def every() -> tuple[Extreme, ...]:
    """Return all extremes, by family in the order of the folder."""
    names = [module.name for module in pkgutil.iter_modules(families.__path__)]
    modules = [importlib.import_module(f"{families.__name__}.{name}") for name in names]
    return tuple(extreme for module in modules for extreme in module.EXTREMES)


def named(name: str) -> Extreme:
    """Return the extreme of that name; ValueError lists what there is."""
    for extreme in every():
        if extreme.name == name:
            return extreme
    raise ValueError(f"extreme = {name!r} is unknown; allowed: {', '.join(e.name for e in every())}")
