"""What changed between two files of records: accuracy by verdict, time as a remark, because no two jobs compare."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from cross_checks.records.lines import key_of
from cross_checks.records.record import Record

FACTOR = 2.0  # errors that differ by less are the same: rounding, magnified by the motion
CLOSED = 1e-11  # m, rad: joints that close better than this do not differ
BY_MACHINE = frozenset({"timeout", "out-of-memory", "engine-missing", "interrupted"})  # say nothing of the code


class Move(StrEnum):
    WORSE = "worse"
    NOT_MEASURED = "not measured"
    BETTER = "better"
    SAME = "same"


@dataclass(frozen=True)
class Change:
    """One run that both files hold."""

    run: str
    move: Move
    sentence: str
    ratio: float | None  # B's loop time over A's


def changes(before: Iterable[Record], after: Iterable[Record]) -> list[Change]:
    """Compare the runs of equal scene, parameters, engine, method and settings; the last of a run counts."""
    old = {key_of(record): record for record in before}
    new = {key_of(record): record for record in after}
    return [_change(old[key], new[key]) for key in old if key in new]


def alone(before: Iterable[Record], after: Iterable[Record]) -> tuple[int, int]:
    """Return how many runs only the first file holds, and how many only the second."""
    old, new = {key_of(r) for r in before}, {key_of(r) for r in after}
    return len(old - new), len(new - old)


def overall(changes: Sequence[Change]) -> Move:
    """Return worse where any run is; else not measured, better or same."""
    moves = {change.move for change in changes}
    return next((move for move in Move if move in moves), Move.NOT_MEASURED)


def median_ratio(changes: Sequence[Change]) -> float | None:
    """Return the median of B's loop times over A's."""
    ratios = [change.ratio for change in changes if change.ratio is not None]
    return float(np.median(ratios)) if ratios else None


def _change(old: Record, new: Record) -> Change:
    move, sentence = _judge(old, new)
    chosen = " ".join(f"{k}={v}" for k, v in new.settings.items() if k in ("step", "rtol"))
    counts = [f"{key}={value}" for key, value in new.parameters.items() if isinstance(value, int)]
    run = " ".join(part for part in (new.scene, *counts, new.engine, new.method, chosen) if part)
    spans = old.times.get("loop_s", 0.0), new.times.get("loop_s", 0.0)
    return Change(run, move, sentence, spans[1] / spans[0] if min(spans) > 0.0 else None)


def _judge(old: Record, new: Record) -> tuple[Move, str]:
    if old.status != new.status:
        text = f"{old.status}, then {new.status}: {new.message}".rstrip(": ")
        if {old.status, new.status} & BY_MACHINE:
            return Move.NOT_MEASURED, text
        if new.status == "success":
            return Move.BETTER, text
        return (Move.WORSE if old.status == "success" else Move.SAME), text
    if old.status != "success":
        return Move.SAME, old.status
    for move, sentence in (_by_error(old, new), _by_gap(old, new)):
        if move is not Move.SAME:
            return move, sentence
    return Move.SAME, ""


def _by_error(old: Record, new: Record) -> tuple[Move, str]:
    if old.error is None or new.error is None:
        both = old.error is None and new.error is None
        return (Move.SAME, "") if both else (Move.NOT_MEASURED, "one of the two has no truth")
    floor = max(old.error.uncertainty, new.error.uncertainty)
    return _grown("error", old.error.value, new.error.value, floor, "of the scene")


def _by_gap(old: Record, new: Record) -> tuple[Move, str]:
    gaps = old.measure("compliance_position"), new.measure("compliance_position")
    if gaps[0] is None or gaps[1] is None:
        return Move.SAME, ""
    return _grown("compliance", gaps[0], gaps[1], CLOSED, "m or rad")


def _grown(what: str, old: float, new: float, floor: float, unit: str) -> tuple[Move, str]:
    text = f"{what} {old:.2e}, then {new:.2e} {unit}"
    if max(old, new) <= floor or max(old, new) <= FACTOR * min(old, new):
        return Move.SAME, text
    return (Move.WORSE if new > old else Move.BETTER), text
