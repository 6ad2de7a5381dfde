"""Mistakes of columns: another unit, convention, sign or time."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from cross_checks.trajectory_files import columns as units
from cross_checks.trajectory_files.formats import FileError
from cross_checks.trajectory_files.mistakes.case import Case, Hypothesis
from cross_checks.trajectory_files.motion import described_motion
from mbs_ref.trajectory import POSES

SWAPPED = {
    "quaternion wxyz": "quaternion xyzw", "quaternion xyzw": "quaternion wxyz",
    "body to world": "world to body", "world to body": "body to world", "body": "world", "world": "body",
}  # fmt: skip


def conventions(case: Case) -> Iterator[Hypothesis]:
    """Yield each other reading of one part's columns, of all bodies at once."""
    for part in POSES:
        stated = next((getattr(b, part) for b in case.stated.bodies.values() if getattr(b, part) is not None), None)
        for word, other in _other_words(part, stated):
            said = f"the {part.replace('_', ' ')} columns look like {other}; {getattr(stated, word)} is stated"
            yield Hypothesis(partial(_read, part, {word: other}), lambda x, said=said: said)


def _read(part: str, change: dict[str, Any], case: Case, x: np.ndarray) -> Case | None:
    bodies = dict(case.stated.bodies)
    for name, body in bodies.items():
        if (columns := getattr(body, part)) is not None:
            bodies[name] = body.model_copy(update={part: columns.model_copy(update=change)})
    stated = case.stated.model_copy(update={"bodies": bodies})
    try:
        return replace(case, stated=stated, path=described_motion(case.scene, case.columns, stated).path)
    except (FileError, ValueError):
        return None


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


def signs(case: Case) -> Iterator[Hypothesis]:
    """Yield a world that is mirrored along an axis, and each component with the other sign."""
    groups = {"the file's world is mirrored": POSES, "positions and velocities are mirrored": ("position", "velocity")}
    groups |= {f"the {part.replace('_', ' ')} has the other sign": (part,) for part in POSES}
    for k, axis in enumerate("xyz"[: case.scene.dimension]):
        for words, parts in groups.items():
            yield Hypothesis(partial(_mirrored, parts, k), lambda x, said=f"{words} along {axis}": said)
    if case.planar:
        said = "orientation and angular velocity count the other way round"
        yield Hypothesis(partial(_mirrored, ("orientation", "angular_velocity"), 0), lambda x: said)


def _mirrored(parts: tuple[str, ...], axis: int, case: Case, x: np.ndarray) -> Case | None:
    """Mirror vectors; turns are axial: along the axis they stay, across it they turn round."""
    mirror = np.ones(case.scene.dimension)
    mirror[axis] = -1.0
    turned = {"position": mirror, "velocity": mirror, "orientation": -1.0, "angular_velocity": -1.0}
    if not case.planar:
        axial = -mirror if len(parts) > 1 else mirror
        turned |= {"orientation": np.append(1.0, axial), "angular_velocity": axial}
    changed = {part: getattr(case.path, part) * turned[part] for part in parts}
    return replace(case, path=replace(case.path, **changed))


def clocks(case: Case) -> Iterator[Hypothesis]:
    """Yield samples, or rates alone, of another time than is stated."""
    slight = 1e-9 * case.scene.duration
    for field, what in (("late", "samples"), ("rates_late", "velocities, by half a step perhaps,")):

        def say(x: np.ndarray, what: str = what) -> str:
            return f"{what} are {'late' if x[0] > 0.0 else 'early'} by {abs(x[0]):.4g} s"

        def change(case: Case, x: np.ndarray, field: str = field) -> Case | None:
            return case.rerun(**{field: getattr(case, field) + float(x[0])})

        yield Hypothesis(change, say, ((0.0,),), True, lambda x: not slight < abs(x[0]) < 0.5 * case.scene.duration)
