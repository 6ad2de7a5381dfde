"""Work-precision sweeps: every method's ladder, accuracy judged and the loop timed alone."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace

from cross_checks import engines as registry
from cross_checks.engine import Method
from cross_checks.isolation.parent import Caller, Lost, direct
from cross_checks.judge import ladder
from cross_checks.judge.one_run import evaluate, without_run
from cross_checks.records.lines import Key, key_of
from cross_checks.records.record import Record
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

REPEATS = 5  # timed runs of a setting, of which the fastest counts
REPEAT_BUDGET = 0.5  # s of loop time after which no more repeats are made
LONGEST = 5.0  # s of loop time after which a ladder climbs no further
HOPELESS = frozenset({"cannot", "engine-missing", "timeout", "out-of-memory"})  # finer would be no better
BUSY = 0.9  # of a processor: a timed run that got less shared the machine
BUSY_NOTE = "timed on a busy machine"

Progress = Callable[[int, int, str], None]  # (methods done, of how many, what comes next)


def sweep(
    scene: Scene,
    engines: Collection[str] | None = None,
    methods: Collection[str] | None = None,
    progress: Progress | None = None,
    *,
    call: Caller = direct,
    known: Iterable[Record] = (),
) -> Iterator[Record]:
    """Yield a record for every rung of every method's ladder; runs are serial, because they are timed.

    The first run of a setting warms up and is judged; the fastest of the repeats is its loop time.
    `call` makes the runs (cross_checks.isolation.parent survives engines that do not come back); settings of
    `known` records, from an interrupted sweep, are not run again. ValueError where an engine or a
    method is unknown.
    """
    tasks, before = _tasks(engines, methods), {key_of(record): record for record in known}
    for done, (engine, method) in enumerate(tasks):
        if progress is not None:
            progress(done, len(tasks), f"{engine} {method.name if method else ''}".strip())
        rungs = [Settings()] if method is None else ladder.rungs(method, scene)
        yield from _climb(scene, engine, rungs, call, before)
    if progress is not None:
        progress(len(tasks), len(tasks), "")


def _tasks(engines: Collection[str] | None, methods: Collection[str] | None) -> list[tuple[str, Method | None]]:
    found: list[tuple[str, Method | None]] = []
    for engine in registry.names() if engines is None else engines:
        try:
            offered = registry.get(engine).methods()
        except registry.EngineMissing:
            found.append((engine, None))
            continue
        found += [(engine, method) for method in offered if methods is None or method.name in methods]
    known = {method.name for _, method in found if method is not None}
    unknown = sorted(set(methods or ()) - known)
    if unknown:
        raise ValueError(f"method = {', '.join(unknown)} is offered by none of the engines asked")
    return found


def _climb(
    scene: Scene, engine: str, rungs: list[Settings], call: Caller, before: dict[Key, Record]
) -> Iterator[Record]:
    for settings in rungs:
        planned = without_run(scene, engine, settings, "", "")
        record = before.get(key_of(planned))
        if record is None:
            record = measured(scene, engine, settings, call)
            yield record
        if record.status in HOPELESS or record.times.get("loop_s", 0.0) > LONGEST:
            return


def measured(scene: Scene, engine: str, settings: Settings, call: Caller) -> Record:
    """Return the judged and timed run; what is lost with its process is a status with a sentence."""
    try:
        return call(measure, scene, engine, settings)
    except Lost as lost:
        return without_run(scene, engine, settings, lost.status, str(lost))


def measure(scene: Scene, engine: str, settings: Settings) -> Record:
    """Run, judge and time one setting."""
    return _timed(scene, evaluate(scene, engine, settings, ladder.grid(scene)), settings)


def _timed(scene: Scene, record: Record, settings: Settings) -> Record:
    """Repeat the run without judging it and keep the fastest loop."""
    if record.status != "success":
        return record
    engine, times = registry.get(record.engine), ladder.grid(scene)
    loops: list[float] = []
    wall, cpu = time.perf_counter(), time.process_time()
    while len(loops) < REPEATS and sum(loops) < REPEAT_BUDGET:
        loops.append(engine.run(scene, settings, times).timing.loop_s)
        if loops[-1] <= 0.0:  # an engine that measures nothing would repeat for nothing
            break
    share = (time.process_time() - cpu) / max(time.perf_counter() - wall, 1e-9)
    spread = {"loop_s": min(loops), "loop_median_s": sorted(loops)[len(loops) // 2], "loop_runs": float(len(loops))}
    notes = record.notes if share >= BUSY else (*record.notes, f"{BUSY_NOTE}: it got {share:.0%} of a processor")
    return replace(record, times=record.times | spread | {"cpu_share": share}, notes=notes)
