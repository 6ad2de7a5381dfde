"""Loop times of what the page ranks: each engine's cheapest setting at each target, alone on the machine.

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

import numpy as np

from benchmarks.timing import BUSY, BUSY_NOTE, with_loops
from cross_checks import engines
from cross_checks.engine import Engine
from cross_checks.isolation.parent import Isolated, Lost
from cross_checks.judge.ladder import grid
from cross_checks.records.naming import run_name
from cross_checks.records.record import Record
from cross_checks.records.store import Store
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from reports.facts.environment import processor

LEAST, MOST = 3, 5  # runs of a setting
NARROW = 0.05  # of the median: half of the interval
ENOUGH = 1.0  # s of loop time
SHARED = " while others used it"  # of a machine's name, under which times of a busy one are kept

Report = Callable[[int, int, str], None]


def timed(store: Store, records: Iterable[Record], report: Report, again: bool = False) -> dict[int, Record]:
    """Return each record, by its id, with its loop times; measured where the store holds none, or `again`."""
    asked, found = list(records), {}
    missing = []
    for record in asked:
        held = None if again else kept_times(store, record)
        if held is None:
            missing.append(record)
        else:
            found[id(record)] = held
    with Isolated() as call:
        for done, record in enumerate(missing):
            report(done, len(missing), f"timing {record.scene} {record.engine} {record.method}")
            found[id(record)] = _measured(store, record, call)
    return found


def kept_times(store: Store, record: Record) -> Record | None:
    """Return the record with the times that the store holds of it on this machine; None where it holds none."""
    key = _key(record)
    quiet = store.timings(key, machine())
    loops = quiet or store.timings(key, machine() + SHARED)
    return with_loops(record, loops, "" if quiet else BUSY_NOTE) if loops else None


def _measured(store: Store, record: Record, call: Isolated) -> Record:
    try:
        loops, share = call(time_loops, record.scene, record.parameters, record.engine, record.settings)
    except (Lost, RuntimeError, ValueError, ArithmeticError) as error:
        return replace(record, notes=(*record.notes, f"not timed: {error}"))
    busy = share < BUSY
    store.keep_timings(_key(record), machine() + (SHARED if busy else ""), loops)
    return with_loops(record, loops, BUSY_NOTE if busy else "")


def time_loops(scene: str, parameters: dict, engine: str, settings: dict) -> tuple[list[float], float]:
    """Return the loop times (s), and the share of a processor that the process got meanwhile; a first run warms up."""
    made, solver, chosen = scenes.make(scene, **parameters), engines.get(engine), Settings(**settings)
    times = grid(made)
    first, share = _loop(solver, made, chosen, times)
    if first > ENOUGH:  # warming up is a small part of it
        return [first], share
    loops: list[float] = []
    shares = []
    while not is_enough(loops):
        loop, share = _loop(solver, made, chosen, times)
        loops.append(loop)
        shares.append(share)
    return loops, float(np.mean(shares))


def _loop(solver: Engine, scene: Scene, settings: Settings, times: np.ndarray) -> tuple[float, float]:
    """Return the time (s) of a run's loop, and the share of a processor that the run got."""
    wall, cpu = time.perf_counter(), time.process_time()
    loop = float(solver.run(scene, settings, times).timing.loop_s)
    return loop, (time.process_time() - cpu) / max(time.perf_counter() - wall, 1e-9)


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


@cache
def machine() -> str:
    """Return what times compare on: the computer and its processor."""
    return f"{platform.node()} {processor()}"


def _key(record: Record) -> str:
    made = _scene(record.scene, tuple(sorted(record.parameters.items())))
    return run_name(made, engines.get(record.engine), Settings(**record.settings), grid(made))


@cache
def _scene(name: str, parameters: tuple) -> Scene:
    return scenes.make(name, **dict(parameters))
