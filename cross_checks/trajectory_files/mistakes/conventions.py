"""Mistakes of conventions and of the clock."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from cross_checks.trajectory_files import columns as units
from cross_checks.trajectory_files.columns import FileError
from cross_checks.trajectory_files.judgement import samples_at
from cross_checks.trajectory_files.mistakes.case import Case
from cross_checks.trajectory_files.motion import described_motion
from cross_checks.truths.truth import NoTruth
from mbs_ref.observables.distance import turn_between
from mbs_ref.trajectory import POSES

SWAPPED = {
    "quaternion wxyz": "quaternion xyzw", "quaternion xyzw": "quaternion wxyz",
    "body to world": "world to body", "world to body": "body to world", "body": "world", "world": "body",
}  # fmt: skip


def other_conventions(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield the case with each other reading of one part's columns, of all bodies at once."""
    for part in POSES:
        stated = next((getattr(b, part) for b in case.stated.bodies.values() if getattr(b, part) is not None), None)
        for word, other in _other_words(part, stated):
            read = _read(case, part, {word: other})
            if read is not None:
                yield f"the {part.replace('_', ' ')} columns look like {other}; {getattr(stated, word)} is stated", read


def _read(case: Case, part: str, change: dict[str, Any]) -> Case | None:
    bodies = {name: _changed(body, part, change) for name, body in case.stated.bodies.items()}
    stated = case.stated.model_copy(update={"bodies": bodies})
    try:
        path = described_motion(case.scene, case.columns, stated).path
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


FITS = 8  # corrections by Gauss and Newton; each squares what is left


def lag(case: Case) -> Iterator[tuple[str, Case]]:
    """Yield a clock that is ahead or behind, fitted by Gauss and Newton on positions and angles."""
    late, now = 0.0, case
    for _ in range(FITS):
        change = _lateness(now)
        if change is None or not abs(change) > 1e-12 * case.scene.duration:
            break
        late += change
        moved = case.path.times - late
        rows = np.flatnonzero((moved >= 0.0) & (moved <= case.scene.duration))
        if len(rows) < 2:
            return
        truth = case.truth_at(moved[rows])
        if isinstance(truth, NoTruth):
            return
        now = replace(case, path=replace(samples_at(case.path, rows), times=moved[rows]), truth=truth)
    if late:
        word = "late" if late > 0.0 else "early"
        yield f"samples are {word} by {abs(late):.4g} s (they tell the state of another time)", now


def _lateness(case: Case) -> float | None:
    """Return by how much (s) the file's samples lag behind, to first order."""
    truth, path, length = case.truth, case.path, case.length
    gaps, rates = [], []
    speed = truth.velocity if truth.velocity is not None else np.gradient(truth.position, path.times, axis=0)
    gaps.append((path.position - truth.position).ravel() / length)
    rates.append(speed.ravel() / length)
    turn = turn_between(path.orientation, truth.orientation, not case.planar)
    if truth.angular_velocity is not None and turn is not None:
        gaps.append(turn.ravel())
        rates.append(truth.angular_velocity.ravel())
    gap, rate = np.concatenate(gaps), np.concatenate(rates)
    known = np.isfinite(gap) & np.isfinite(rate)
    square = float(np.sum(rate[known] ** 2))
    return -float(np.sum(gap[known] * rate[known])) / square if square > 0.0 else None
