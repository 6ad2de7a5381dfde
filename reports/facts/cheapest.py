"""Cost at equal error: each engine's cheapest run at a target."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cross_checks.judge.bounds import TARGETS
from cross_checks.records.record import Record
from mbs_ref.trajectory import Status
from reports.facts.report_data import Cell, ReportData

NEAR = 1.5  # times the cheapest first run: settings that near are timed, too, since first runs are noisy
RANK = ("not-tried", "not-reached", "unjudged", "cannot")  # which of its methods' answers speaks for an engine


@dataclass(frozen=True)
class Entry:
    """What an engine offers at a target error."""

    engine: str
    answer: str  # reached | not-reached | not-tried | cannot | unjudged
    best: Record | None = None  # its cheapest run, where it reached the target
    reason: str = ""
    method: str = ""


def usable(record: Record) -> bool:
    """Return whether the run finished and was measured against a truth."""
    return record.status == Status.SUCCESS and record.error is not None and record.times.get("loop_s") is not None


def known_error(record: Record) -> float:
    """Return the error with the truth's uncertainty added, as `mbs-ref pick` counts it."""
    assert record.error is not None
    return record.error.bound


def floor(records: Iterable[Record]) -> float:
    """Return the smallest error that the records' truth judges."""
    return max((r.error.floor for r in records if r.error), default=0.0)


def loop_time(record: Record) -> float:
    """Return the loop time (s) by which runs are ranked."""
    return record.times.get("loop_s", float("inf"))


def reaching(data: ReportData, scene: str, engine: str, target: float) -> list[Record]:
    """Return the cheapest run of each of an engine's methods that reaches a target on a scene, cheapest first."""
    told = ((cell, asked) for cell in data.cells_of(scene, engine) for asked in cell.targets)
    found = [data.record(cell, asked.setting) for cell, asked in told if asked.target == target and asked.setting]
    return sorted((record for record in found if record is not None), key=loop_time)


def entries(data: ReportData, scene: str, target: float) -> list[Entry]:
    """Return one entry an engine, the cheapest first, those that missed the target last."""
    return data.once(("entries", scene, target), lambda: _entries(data, scene, target))


def _entries(data: ReportData, scene: str, target: float) -> list[Entry]:
    found = [_entry(data, scene, engine, target) for engine in data.engines]
    return sorted(found, key=lambda e: loop_time(e.best) if e.best else float("inf"))


def _entry(data: ReportData, scene: str, engine: str, target: float) -> Entry:
    runs = reaching(data, scene, engine, target)
    if runs:
        return Entry(engine, "reached", runs[0], method=runs[0].method)
    told = ((cell, asked) for cell in data.cells_of(scene, engine) for asked in cell.targets if asked.target == target)
    missed = [(RANK.index(asked.answer), cell, asked) for cell, asked in told if asked.answer in RANK]
    if not missed:
        return Entry(engine, "cannot", reason="no method of it was asked")
    _, cell, asked = min(missed, key=lambda item: (item[0], _smallest(item[1])))
    return Entry(engine, asked.answer, None, asked.reason or cell.reason, cell.method)


def _smallest(cell: Cell) -> float:
    return float("inf") if cell.error is None else cell.error


def contenders(data: ReportData) -> list[Record]:
    """Return the runs that may be an engine's cheapest at a target: what is timed."""
    found: dict[int, Record] = {}
    for scene in data.scenes:
        for engine in data.engines:
            for target in TARGETS:
                runs = reaching(data, scene, engine, target)
                found |= {id(r): r for r in runs if loop_time(r) <= NEAR * loop_time(runs[0])}
    return list(found.values())


def representative(records: list[Record], target: float = 1e-6) -> list[Record]:
    """Return one record for each engine and method: the cheapest within `target`, else its most accurate."""
    chosen = []
    for key in dict.fromkeys((r.engine, r.method) for r in records):
        own = [r for r in records if (r.engine, r.method) == key]
        measured = [r for r in own if usable(r)]
        within = [r for r in measured if known_error(r) <= target]
        chosen.append(min(within, key=loop_time, default=None) or min(measured, key=known_error, default=own[-1]))
    return chosen


def best_of_engines(records: list[Record], target: float = 1e-6) -> list[Record]:
    """Return one record for each engine: its cheapest within `target`, else its most accurate."""
    chosen = representative(records, target)
    found = []
    for engine in dict.fromkeys(r.engine for r in chosen):
        own = [r for r in chosen if r.engine == engine]
        measured = [r for r in own if usable(r)]
        within = [r for r in measured if known_error(r) <= target]
        found.append(min(within, key=loop_time, default=None) or min(measured, key=known_error, default=own[0]))
    return found
