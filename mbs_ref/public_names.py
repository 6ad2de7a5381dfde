"""The names that a package offers, looked up when they are first used: importing the package takes no time."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping


def lazily(
    package: str, names: Mapping[str, str], rooms: tuple[str, ...]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return a package's __getattr__ and __dir__ (PEP 562), of names by their modules and folders for use themselves.

    An unknown name raises AttributeError, which lists those there are.
    """
    public = sorted((*names, *rooms))

    def look_up(name: str) -> object:
        if name in rooms:
            return importlib.import_module(f"{package}.{name}")
        if name not in names:
            raise AttributeError(f"{package} has no {name!r}; public are {', '.join(public)}")
        return getattr(importlib.import_module(names[name]), name)

    return look_up, lambda: list(public)
