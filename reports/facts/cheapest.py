"""Cost at equal error: each engine's cheapest run at a target."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import ANSWERS, Answer, Cell
from cross_checks.records.record import Record
from mbs_ref.trajectory import Status
from reports.facts.report_data import ReportData

NEAR = 1.5  # times the cheapest first run: settings that near are timed, too, since first runs are noisy


@dataclass(frozen=True)
class Entry:
    """What an engine offers at a target error."""

    engine: str
    answer: Answer
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
    results = [result for cell in data.cells_of(scene, engine) if (result := cell.result(target)) is not None]
    return sorted((data.measured(result.record) for result in results if result.record is not None), key=loop_time)


def entries(data: ReportData, scene: str, target: float) -> list[Entry]:
    """Return one entry an engine, the cheapest first, those that missed the target last."""
    return data.once(("entries", scene, target), lambda: _entries(data, scene, target))


def _entries(data: ReportData, scene: str, target: float) -> list[Entry]:
    every = [_entry(data, scene, engine, target) for engine in data.engines]
    return sorted(every, key=lambda e: loop_time(e.best) if e.best else float("inf"))


def _entry(data: ReportData, scene: str, engine: str, target: float) -> Entry:
    runs = reaching(data, scene, engine, target)
    if runs:
        return Entry(engine, "reached", runs[0], method=runs[0].method)
    results = [(cell, result) for cell in data.cells_of(scene, engine) if (result := cell.result(target)) is not None]
    if not results:
        return Entry(engine, "cannot", reason="none of its methods was run for this target")
    cell, result = min(results, key=lambda item: (list(ANSWERS).index(item[1].answer), _error(item[0])))
    return Entry(engine, result.answer, None, result.reason or cell.reason, cell.method)


def _error(cell: Cell) -> float:
    return float("inf") if cell.error is None else cell.error


def contenders(data: ReportData) -> list[Record]:
    """Return the runs that may be an engine's cheapest at a target."""
    every = (run for s in data.scenes for e in data.engines for t in TARGETS for run in near(reaching(data, s, e, t)))
    return list({id(run): run for run in every}.values())


def near(runs: Sequence[Record]) -> list[Record]:
    """Return the runs, sorted by loop time, that may be the cheapest when they are timed again."""
    return [run for run in runs if loop_time(run) <= NEAR * loop_time(runs[0])]


def best_of_engines(records: Sequence[Record], target: float = 1e-6) -> list[Record]:
    """Return one record for each engine: its cheapest within `target`, else its most accurate, else its last."""

    def preference(record: Record) -> tuple[int, float]:
        if not usable(record):
            return (2, 0.0)
        error = known_error(record)
        return (0, loop_time(record)) if error <= target else (1, error)

    names = dict.fromkeys(r.engine for r in records)
    return [min((r for r in reversed(records) if r.engine == name), key=preference) for name in names]
