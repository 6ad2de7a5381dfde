"""The engines: every file named *_.py in this folder, and entry points of the group mbs_ref.engines."""

from __future__ import annotations

import re
from difflib import get_close_matches
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path

from cross_checks.engine import Engine

GROUP = "mbs_ref.engines"


class EngineMissing(ImportError):
    """The engine's own package is not installed."""


def _entry_points() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=GROUP)}


def _files() -> list[str]:
    return sorted(path.stem.removesuffix("_") for path in Path(__file__).parent.glob("*[!_]_.py"))


def names() -> list[str]:
    """Return every engine's name: the reference first, then the folder's, then the entry points'."""
    known = sorted({*_files(), *_entry_points()})
    return sorted(known, key=lambda name: name != "mbs_ref")


def get(name: str) -> Engine:
    """Return the named engine.

    ValueError lists what is allowed; EngineMissing says that its own package is absent; any other
    failure to import is a broken adapter and propagates.
    """
    if name in _files():
        return _create(f"cross_checks.engines.{name}_", name)
    outside = _entry_points()
    if name in outside:
        return _create(outside[name].module, name, outside[name].attr or None)
    raise ValueError(f"engine = {name!r} is unknown; {_suggestion(name)}allowed: {', '.join(names())}")


def _suggestion(name: str) -> str:
    close = get_close_matches(name, names(), n=1)
    return f"did you mean {close[0]!r}? " if close else ""


def _create(module_name: str, name: str, attribute: str | None = None) -> Engine:
    """Import the adapter and create its engine: the class an entry point names, else the module's ENGINE."""
    try:
        module = import_module(module_name)
        return getattr(module, attribute or "ENGINE")()
    except ModuleNotFoundError as error:
        if error.name != _package(module_name):
            raise
        raise EngineMissing(f"engine {name!r} needs the package {error.name!r}: {error}", name=error.name) from error


def _package(module_name: str) -> str | None:
    """Return the `package` an adapter's source declares: read, because importing is what failed."""
    spec = find_spec(module_name)
    if spec is None or spec.origin is None:
        return None
    declared = re.search(r"^\s+package\b[^=]*=\s*[\"']([\w.]+)[\"']", Path(spec.origin).read_text(), re.MULTILINE)
    return declared.group(1) if declared else None
