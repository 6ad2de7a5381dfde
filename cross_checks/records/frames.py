"""Records, verdicts and samples as data frames of pandas or Polars."""

import importlib
from collections.abc import Iterable, Iterator
from typing import Any

from cross_checks.records.record import Record
from cross_checks.records.store import Run
from mbs_ref import Scene
from mbs_ref.trajectory import POSES, Trajectory, pose_columns

LIBRARIES = ("pandas", "polars")


def frame(items: Iterable[Any], library: str = "pandas") -> Any:
    """Return records, runs or verdicts as a data frame, one row each.

    Nested data become columns with a dot (`error.value`, `times.loop_s`, `settings.step`); curves and final states stay
    with the records. ValueError for an unknown library, ImportError with what to install where it is missing.
    """
    made = _library(library)
    rows = [dict(_flat(_plain(item))) for item in items]
    names = list(dict.fromkeys(name for row in rows for name in row))
    return made.DataFrame({name: [row.get(name) for row in rows] for name in names})


def samples(scene: Scene, path: Trajectory, library: str = "pandas") -> Any:
    """Return a motion as a data frame: `t` (s) and columns such as rod.x, rod.angle, rod.vx, as `simulate -o` has."""
    made = _library(library)
    parts = (getattr(path, name) for name in POSES)
    return made.DataFrame({"t": path.times, **pose_columns(scene.body_names, parts)})


def _library(name: str) -> Any:
    if name not in LIBRARIES:
        raise ValueError(f"library = {name!r} is unknown; allowed: {', '.join(LIBRARIES)}")
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            raise
        raise ImportError(f"frames of {name} need the package {name}: pip install {name}", name=name) from error


def _plain(item: Any) -> dict[str, Any]:
    given = item.record if isinstance(item, Run) else item
    plain = dict(given.to_dict())
    if isinstance(given, Record):
        for curve in ("final", "history", "events"):
            plain.pop(curve)
    return plain


def _flat(plain: dict[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the leaves of nested data by dotted names; lists as one text."""
    for key, value in plain.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{above}{key}.")
        elif isinstance(value, list | tuple):
            yield f"{above}{key}", "; ".join(map(str, value))
        else:
            yield f"{above}{key}", value
