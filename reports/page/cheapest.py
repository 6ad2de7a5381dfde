"""Cost at equal error: the cheapest run that reached an error."""

from __future__ import annotations

from dataclasses import dataclass

from cross_checks.records.record import Record
from mbs_ref.trajectory import Status

TARGETS = (1e-3, 1e-6, 1e-9)  # m


@dataclass(frozen=True)
class Entry:
    """An engine's cheapest run at an error, or the best it reached instead."""

    engine: str
    best: Record | None  # None: the error was not reached
    reached: float | None  # m, the smallest error of any run; None when no run finished


def usable(record: Record) -> bool:
    """Return whether the run finished and was measured against a truth."""
    return record.status == Status.SUCCESS and record.error is not None and record.times.get("loop_s") is not None


def known_error(record: Record) -> float:
    """Return the error (m) with the truth's uncertainty added, as `mbs-ref pick` counts it."""
    assert record.error is not None
    return record.error.bound


def floor(records: list[Record]) -> float:
    """Return the smallest error (m) that the records' truth judges."""
    return max((r.error.floor for r in records if r.error), default=0.0)


def cheapest(records: list[Record], target: float) -> Record | None:
    """Return the record with the shortest loop among those within `target` (m) of the truth."""
    within = [r for r in records if usable(r) and known_error(r) <= target]
    return min(within, key=lambda r: r.times["loop_s"], default=None)


def entries(records: list[Record], engines: list[str], target: float) -> list[Entry]:
    """Return one entry an engine, the cheapest first, those that missed the error last."""
    found = []
    for engine in engines:
        own = [r for r in records if r.engine == engine]
        reached = min((known_error(r) for r in own if usable(r)), default=None)
        found.append(Entry(engine, cheapest(own, target), reached))
    return sorted(found, key=lambda e: e.best.times["loop_s"] if e.best else float("inf"))


def representative(records: list[Record], target: float = 1e-6) -> list[Record]:
    """Return one record for each engine and method: the cheapest within `target`, else its most accurate."""
    chosen = []
    for key in dict.fromkeys((r.engine, r.method) for r in records):
        own = [r for r in records if (r.engine, r.method) == key]
        measured = [r for r in own if usable(r)]
        nearest = min(measured, key=known_error, default=None)
        chosen.append(cheapest(own, target) or nearest or own[-1])
    return chosen
