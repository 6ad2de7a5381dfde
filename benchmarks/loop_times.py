"""Loop times of runs alone on the machine.

A setting is run again until the half-width of its interval is below 5 % of the median, three to five times: the rule
of hyperfine, with a bound; a loop of more than ENOUGH seconds is made once. Times are kept in the store by run
and machine. One taken while others used the machine is kept apart, marked, and gives way to a quiet one.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.timing import BUSY, BUSY_NOTE, Sample, with_loops
from cross_checks import engines
from cross_checks.isolation.parent import Caller, Isolated, Lost
from cross_checks.judge.ladder import grid
from cross_checks.records.naming import run_name
from cross_checks.records.record import Record
from cross_checks.records.store import Store
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

LEAST, MOST = 3, 5  # runs of a setting
NARROW = 0.05  # of the median: half of the interval
ENOUGH = 1.0  # s of loop time
CPU_FACTS = Path("/proc/cpuinfo")  # Linux; elsewhere the platform module knows
SHARED = " while others used it"  # of a machine's name, under which times of a busy one are kept

Report = Callable[[int, int, str], None]


def timed_all(store: Store, records: Iterable[Record], report: Report, again: bool = False) -> dict[int, Record]:
    """Return each record, by its id, with its loop times; measured where the store holds none, or `again`."""
    scene_of = cache(lambda name, parameters: scenes.make(name, **dict(parameters)))
    placed = [(record, scene_of(record.scene, tuple(sorted(record.parameters.items())))) for record in records]
    found = {} if again else {id(record): stored_times(store, scene, record) for record, scene in placed}
    missing = [(record, scene) for record, scene in placed if found.get(id(record)) is None]
    with Isolated() as call:
        for done, (record, scene) in enumerate(missing):
            report(done, len(missing), f"timing {record.scene} {record.engine} {record.method}")
            found[id(record)] = measured(store, call, scene, record)
    return {key: record for key, record in found.items() if record is not None}


def timed(store: Store, call: Caller, scene: Scene, record: Record) -> Record:
    """Return the record of a successful run with loop times of an idle machine, measured where the store holds none."""
    if record.status != "success":
        return record
    loops = store.timings(_key(scene, record), machine())
    return with_loops(record, loops) if loops else measured(store, call, scene, record)


def stored_times(store: Store, scene: Scene, record: Record) -> Record | None:
    """Return the record with the times that the store holds of it on this machine; None where it holds none."""
    key = _key(scene, record)
    quiet = store.timings(key, machine())
    loops = quiet or store.timings(key, machine() + SHARED)
    return with_loops(record, loops, "" if quiet else BUSY_NOTE) if loops else None


def measured(store: Store, call: Caller, scene: Scene, record: Record) -> Record:
    """Return the record with its loop times, which the store keeps; with a note where no run came back."""
    try:
        loops, share = call(time_loops, scene, record.engine, Settings(**record.settings))
    except (Lost, RuntimeError, ValueError, ArithmeticError) as error:
        return replace(record, notes=(*record.notes, f"not timed: {error}"))
    busy = share < BUSY
    store.keep_timings(_key(scene, record), machine() + (SHARED if busy else ""), loops)
    return with_loops(record, loops, BUSY_NOTE if busy else "")


def time_loops(scene: Scene, engine: str, settings: Settings) -> tuple[list[float], float]:
    """Return the loop times (s), and the share of a processor that the process got meanwhile; a first run warms up."""
    first = sample(scene, engine, settings)
    if first.loop_s > ENOUGH:  # warming up is a small part of it
        return [first.loop_s], first.cpu_share
    samples: list[Sample] = []
    while not is_enough([one.loop_s for one in samples]):
        samples.append(sample(scene, engine, settings))
    return [one.loop_s for one in samples], float(np.mean([one.cpu_share for one in samples]))


def sample(scene: Scene, engine: str, settings: Settings) -> Sample:
    """Return the time (s) of a run's loop, and the share of a processor that the run got."""
    solver, times = engines.get(engine), grid(scene)
    wall, cpu = time.perf_counter(), time.process_time()
    loop = float(solver.run(scene, settings, times).timing.loop_s)
    return Sample(loop, (time.process_time() - cpu) / max(time.perf_counter() - wall, 1e-9))


def is_enough(loops: list[float]) -> bool:
    """Whether the interval is narrow, or the bound on runs or on time is met."""
    if len(loops) < LEAST:
        return False
    return len(loops) >= MOST or half_width(loops) < NARROW or sum(loops) > ENOUGH


def half_width(loops: list[float]) -> float:
    """Return half of the spread of the loop times over their median; 0 where nothing was measured."""
    middle = float(np.median(loops))
    return 0.0 if middle <= 0.0 else 0.5 * (max(loops) - min(loops)) / middle


def is_timed(record: Record) -> bool:
    """Whether the loop was timed alone, several times."""
    return "loop_runs" in record.times


def is_busy(record: Record) -> bool:
    """Whether the loop was timed while others used the machine."""
    return BUSY_NOTE in record.notes


def processor() -> str:
    """Return the processor's name."""
    lines = CPU_FACTS.read_text().splitlines() if CPU_FACTS.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return next(iter(models), platform.processor() or platform.machine())


@cache
def machine() -> str:
    """Return what times compare on: the computer and its processor."""
    return f"{platform.node()} {processor()}"


def _key(scene: Scene, record: Record) -> str:
    return run_name(scene, engines.get(record.engine), Settings(**record.settings), grid(scene))
