"""Other readings of the columns: another unit, another order of the quaternion, another direction or set of axes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from cross_checks.trajectory_files import units
from cross_checks.trajectory_files.columns import STATE, FileError
from cross_checks.trajectory_files.mistakes.case import Case
from cross_checks.trajectory_files.told_motion import told_motion

SWAPPED = {
    "quaternion wxyz": "quaternion xyzw", "quaternion xyzw": "quaternion wxyz",
    "body to world": "world to body", "world to body": "body to world", "body": "world", "world": "body",
}  # fmt: skip


def other_conventions(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield the case with each other reading of one part's columns, of all bodies at once."""
    for part in STATE:
        stated = next((getattr(b, part) for b in case.stated.bodies.values() if getattr(b, part) is not None), None)
        for word, other in _other_words(part, stated):
            read = _read(case, part, {word: other})
            if read is not None:
                yield f"the {part.replace('_', ' ')} columns look like {other}; {getattr(stated, word)} is stated", read


def _read(case: Case, part: str, change: dict[str, Any]) -> Case | None:
    bodies = {name: _changed(body, part, change) for name, body in case.stated.bodies.items()}
    stated = case.stated.model_copy(update={"bodies": bodies})
    try:
        path = told_motion(case.scene, case.columns, stated).path
    except (FileError, ValueError):
        return None
    if len(path.times) != len(case.path.times):  # samples were dropped where a lag was taken off
        return None
    return replace(case, stated=stated, path=replace(path, times=case.path.times))


def _changed(body: Any, part: str, change: dict[str, Any]) -> Any:
    told = getattr(body, part)
    return body if told is None else body.model_copy(update={part: told.model_copy(update=change)})


def _other_words(part: str, stated: Any) -> Iterator[tuple[str, str]]:
    """Yield a field of the statement and another value of it."""
    if stated is None:
        return
    kind = {"position": "length", "orientation": "angle"}.get(part, part.replace("_", " "))
    if stated.unit is not None:
        yield from (("unit", unit) for unit in units.allowed(kind) if unit != stated.unit)
    for word in ("convention", "maps", "axes"):
        value = getattr(stated, word, None)
        if value in SWAPPED:
            yield word, SWAPPED[value]
    if getattr(stated, "convention", "").startswith("euler"):
        order = stated.convention.removeprefix("euler ")
        yield from (("convention", f"euler {other}") for other in (order.swapcase(), order[::-1]))
