"""Work against precision: the settings that meet a row of target errors, each with its loop timed alone."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

from benchmarks.timing import BUSY, BUSY_NOTE, with_loops
from cross_checks import engines as registry
from cross_checks.engine import Method
from cross_checks.isolation.parent import Lost
from cross_checks.judge.answers import Answer, Progress, Question, answers, questions
from cross_checks.judge.cell import tasks
from cross_checks.judge.ladder import grid
from cross_checks.judge.one_run import without_run
from cross_checks.judge.runs import Runs
from cross_checks.records.naming import run_name
from cross_checks.records.record import Record
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

DECADES = tuple(10.0**-k for k in range(2, 11))  # targets of a sweep, over the scene's scales
REPEATS = 5  # timed runs of a setting, of which the fastest counts
REPEAT_BUDGET = 0.5  # s of loop time after which no more repeats are made

Worth = Callable[[Sequence[Record]], Collection[Record]]  # those of all runs that are timed


def sweep(
    runs: Runs, scene: Scene, engines: Collection[str] | None = None, methods: Collection[str] | None = None,
    progress: Progress = lambda done, total, what: None, targets: Sequence[float] = DECADES,
    seen: Callable[[list[Record]], None] = lambda records: None, worth: Worth | None = None,
) -> Iterator[Record]:  # fmt: skip
    """Yield every run of every method's search for the targets, judged and timed, coarse to fine.

    Runs are made on all processors, where `runs` makes them in processes of their own, and then timed one at a time.
    `seen` receives all runs so far, not timed yet. With `worth` only those are timed that it returns, and slow methods
    are left out where it returns any. Without a certified truth, errors are from what engines agree on. ValueError
    where an engine or a method is unknown.
    """
    asked = questions([scene], _offered(engines, methods))
    found: dict[Question, list[Record]] = {}
    for patient in (worth is None, True):
        for answer in answers(runs, asked, targets, progress, patient):
            found[answer.question] = _records(answer)
            seen([record for question in asked for record in found.get(question, [])])
        records = [record for question in asked for record in found.get(question, [])]
        chosen = [id(record) for record in (records if worth is None else worth(records))]
        if patient or chosen:
            break
    for number, record in enumerate(records):
        progress(number, len(records), f"timing {record.engine} {record.method}")
        yield timed(runs, scene, record) if id(record) in chosen else record


def _offered(engines: Collection[str] | None, methods: Collection[str] | None) -> list[tuple[str, Method | None]]:
    offered = tasks(registry.names() if engines is None else engines)
    unknown = sorted(set(methods or ()) - {method.name for _, method in offered if method is not None})
    if unknown:
        raise ValueError(f"method = {', '.join(unknown)} is offered by none of the engines")
    return [(engine, method) for engine, method in offered if methods is None or (method and method.name in methods)]


def _records(answer: Answer) -> list[Record]:
    """Return the runs of an answer; where the method cannot run, a record that states why."""
    cell, scene = answer.cell, answer.question.scene
    status = str(cell.verdict)
    refused = without_run(scene, cell.engine, Settings(method=cell.method or None), status, cell.reason)
    return list(answer.records) or [refused]


def timed(runs: Runs, scene: Scene, record: Record) -> Record:
    """Return a record with the loop times of some repeats on this machine; the store keeps those of an idle one."""
    if record.status != "success":
        return record
    settings = Settings(**record.settings)
    key = run_name(scene, registry.get(record.engine), settings, grid(scene))
    loops = runs.store.timings(key, host())
    if loops:
        return with_loops(record, loops)
    try:
        loops, share = runs.call(loops_of, scene, record.engine, settings)
    except Lost as lost:
        return replace(record, notes=(*record.notes, f"not timed: a repeat {lost}"))
    if share < BUSY:
        return with_loops(record, loops, f"{BUSY_NOTE}: it got {share:.0%} of a processor")
    runs.store.keep_timings(key, host(), loops)
    return with_loops(record, loops)


def loops_of(scene: Scene, engine: str, settings: Settings) -> tuple[list[float], float]:
    """Repeat a run without judging it; return its loop times (s) and the share of a processor that it got."""
    solver, times = registry.get(engine), grid(scene)
    loops: list[float] = []
    wall, cpu = time.perf_counter(), time.process_time()
    while len(loops) < REPEATS and sum(loops) < REPEAT_BUDGET:
        loops.append(solver.run(scene, settings, times).timing.loop_s)
        if loops[-1] <= 0.0:  # an engine that measures nothing would repeat for nothing
            break
    return loops, (time.process_time() - cpu) / max(time.perf_counter() - wall, 1e-9)


def host() -> str:
    """Return the machine that a time belongs to."""
    return f"{platform.node()} {platform.machine()}"
