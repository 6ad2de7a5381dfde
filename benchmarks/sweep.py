"""Work against precision: the settings that meet a row of target errors, each with its loop timed alone."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace

from benchmarks.timing import BUSY, BUSY_NOTE, with_loops
from cross_checks import engines as registry
from cross_checks.engine import Method
from cross_checks.isolation.parent import Caller, Isolated, Lost
from cross_checks.isolation.workers import each
from cross_checks.judge.cell import refused, tasks, truth_of
from cross_checks.judge.ladder import grid
from cross_checks.judge.one_run import without_run
from cross_checks.judge.runs import Runs
from cross_checks.judge.search import search
from cross_checks.records.naming import run_name
from cross_checks.records.record import CANNOT, MISSING, Record
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

DECADES = tuple(10.0**-k for k in range(2, 11))  # targets of a sweep, over the scene's scales
REPEATS = 5  # timed runs of a setting, of which the fastest counts
REPEAT_BUDGET = 0.5  # s of loop time after which no more repeats are made

Progress = Callable[[int, int, str], None]  # (done, of how many, what is made); a method counts twice, run and timed
Asked = tuple[str, Method | None]  # an engine and its method; none where the engine is not installed


def sweep(
    runs: Runs, scene: Scene, engines: Collection[str] | None = None, methods: Collection[str] | None = None,
    progress: Progress | None = None, targets: Sequence[float] = DECADES,
) -> Iterator[Record]:  # fmt: skip
    """Yield every run of every method's search for the targets, judged and timed, coarse to fine.

    Runs are made on all processors, where `runs` makes them in processes of their own, and then timed one at a time.
    Without a certified truth, errors are from what engines agree on. ValueError where an engine or a method is unknown.
    """
    report = progress or (lambda done, total, what: None)
    listed = _asked(engines, methods)
    truth = truth_of(runs, scene)
    found: dict[int, list[Record]] = {}
    for number, records in _searched(runs, scene, listed, truth, targets):
        found[number] = records
        report(len(found), 2 * len(listed), f"runs, {_name(*listed[number])}")
    for number, asked in enumerate(listed):
        report(len(listed) + number, 2 * len(listed), f"timing, {_name(*asked)}")
        for record in found[number]:
            yield timed(runs, scene, record)
    report(2 * len(listed), 2 * len(listed), "")


def _asked(engines: Collection[str] | None, methods: Collection[str] | None) -> list[Asked]:
    offered = tasks(registry.names() if engines is None else engines)
    unknown = sorted(set(methods or ()) - {method.name for _, method in offered if method is not None})
    if unknown:
        raise ValueError(f"method = {', '.join(unknown)} is offered by none of the engines asked")
    return [(engine, method) for engine, method in offered if methods is None or (method and method.name in methods)]


def _searched(
    runs: Runs, scene: Scene, listed: Sequence[Asked], truth: Truth | NoTruth, targets: Sequence[float]
) -> Iterator[tuple[int, list[Record]]]:
    """Yield the number and the runs of every method as they come; from this process where runs cannot leave it."""

    def search_in(call: Caller, number: int) -> list[Record]:
        return _of_method(replace(runs, call=call), scene, *listed[number], truth, targets)

    numbers = range(len(listed))
    if isinstance(runs.call, Isolated):
        yield from each(numbers, search_in, timeout=runs.call.timeout, memory=runs.call.memory)
    else:
        yield from ((number, search_in(runs.call, number)) for number in numbers)


def _of_method(
    runs: Runs, scene: Scene, engine: str, method: Method | None, truth: Truth | NoTruth, targets: Sequence[float]
) -> list[Record]:
    """Return every run of a method's search, judged, coarse to fine; where it cannot run, why."""
    name, reason = refused(scene, engine, method)
    if method is None or reason:
        settings = Settings() if method is None else Settings(method=name)
        return [without_run(scene, engine, settings, MISSING if method is None else CANNOT, reason)]
    tried, _ = search(runs, scene, engine, method, truth, targets)
    return [tried.records[knob] for knob in tried.knobs]


def _name(engine: str, method: Method | None) -> str:
    return engine if method is None else f"{engine} {method.name}"


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
