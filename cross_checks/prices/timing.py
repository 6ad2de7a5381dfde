"""Loop times: of runs in randomly interleaved turns, of two things against each other, of runs alone on the machine.

A setting is run again until the half-width of its interval is below 5 % of the median, three to five times: the rule
of hyperfine, with a bound; a loop of more than ENOUGH seconds is run once. The store holds times by run and machine;
the first one of a loop of more than WARMED seconds is that of the search, if the run had a processor to itself.
Times measured while others used the machine are marked, and are replaced by those of an idle one.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache, partial
from statistics import median
from typing import NamedTuple

import numpy as np

from cross_checks import engines
from cross_checks.engines.elsewhere import processor_time
from cross_checks.isolation.parent import Caller, Isolated, Lost
from cross_checks.isolation.workers import Report
from cross_checks.judge.ladder import grid
from cross_checks.records.record import BUSY, BUSY_NOTE, WARMED, Record, machine
from cross_checks.records.store import Store, run_name
from mbs_ref import Scene, Settings, scenes

PAIRS = 5  # runs of each in a block, of which the fastest counts
FEWEST_BLOCKS, MOST_BLOCKS = 10, 40  # of a comparison
LIMIT = 1.05  # a ratio of times within 1/LIMIT and LIMIT is the same
RESAMPLES = 1000
AGAIN = 3  # times a disturbed run is repeated
FEWEST_RUNS, MOST_RUNS = 3, 5  # of a setting
NARROW = 0.05  # of the median: half of the interval
ENOUGH = 1.0  # s of loop time: a longer run is timed once, a scheduler's quanta are small beside it
ROUNDS = 3  # turns, of which a run's least time counts
SHARED = " while others used it"  # of a machine's name, under which times of a busy one are stored


def interleaved[T](
    runs: Sequence[Callable[[], T]], rounds: int, random: np.random.Generator | None = None
) -> list[list[T]]:
    """Return what each run returns in `rounds` turns; each turn has a random order of its own."""
    random = random or np.random.default_rng(0)
    results: list[list[T]] = [[] for _ in runs]
    for _ in range(rounds):
        for k in random.permutation(len(runs)):
            results[k].append(runs[k]())
    return results


class Sample(NamedTuple):
    """One timed run."""

    loop_s: float
    cpu_share: float = 1.0  # of a processor, while it ran


def least_times(runs: Sequence[Callable[[], float]], first: Sequence[Sample]) -> list[float]:
    """Return the least time (s) of each run, which returns its own, in interleaved turns.

    A run's first sample is one of its ROUNDS turns, if it had a processor to itself; one turn is enough for a loop of
    more than ENOUGH.
    """
    best = [own.loop_s if own.cpu_share >= BUSY else np.inf for own in first]
    for turn in range(ROUNDS):
        due = [k for k, own in enumerate(first) if (turn == 0 and best[k] == np.inf) or (turn and own.loop_s <= ENOUGH)]
        for k, times in zip(due, interleaved([runs[k] for k in due], 1), strict=True):
            best[k] = min(best[k], *times)
    return best


class Pace(StrEnum):
    FASTER = "faster"
    SAME = "same"
    SLOWER = "slower"
    INCONCLUSIVE = "inconclusive"


@dataclass(frozen=True)
class Comparison:
    """How the second thing's time compares with the first's."""

    pace: Pace
    ratio: float  # median over blocks
    low: float  # 95 % bootstrap interval of the median
    high: float
    blocks: int
    disturbed: float  # share of runs that shared the machine, although they were repeated


def with_loops(record: Record, loops: Sequence[float], note: str = "") -> Record:
    """Return the record with its loop times (s): the least, the median, the largest; `note` is added to its notes."""
    times = {"loop_s": min(loops), "loop_median_s": median(loops), "loop_most_s": max(loops)}
    notes = (*record.notes, note) if note else record.notes
    return replace(record, times=record.times | times | {"loop_runs": float(len(loops))}, notes=notes)


def compare(
    first: Callable[[], Sample], second: Callable[[], Sample], seed: int = 0, limit: float = LIMIT
) -> Comparison:
    """Time both until the verdict is clear or MOST_BLOCKS are spent; ratios within 1/limit and limit are the same."""
    random = np.random.default_rng(seed)
    ratios: list[float] = []
    disturbed = 0
    while True:
        block = interleaved([partial(_undisturbed, first), partial(_undisturbed, second)], PAIRS, random)
        before, after = (min(sample.loop_s for sample in samples) for samples in block)
        ratios.append(after / before)
        disturbed += sum(sample.cpu_share < BUSY for samples in block for sample in samples)
        if len(ratios) < FEWEST_BLOCKS:
            continue
        low, high = interval(np.array(ratios), random)
        ratio = float(np.median(ratios))
        pace = verdict(ratio, low, high, limit)
        if pace is not Pace.INCONCLUSIVE or len(ratios) == MOST_BLOCKS:
            share = disturbed / (2 * PAIRS * len(ratios))
            return Comparison(pace, ratio, low, high, len(ratios), share)


def verdict(ratio: float, low: float, high: float, limit: float = LIMIT) -> Pace:
    """Faster or slower where the median is beyond the limit and the interval leaves out 1; same where all is within."""
    if ratio > limit and low > 1.0:
        return Pace.SLOWER
    if ratio < 1.0 / limit and high < 1.0:
        return Pace.FASTER
    return Pace.SAME if high < limit and low > 1.0 / limit else Pace.INCONCLUSIVE


def interval(ratios: np.ndarray, random: np.random.Generator) -> tuple[float, float]:
    """Return the 95 % bootstrap interval of the median (Efron 1979, percentile method)."""
    medians = np.median(random.choice(ratios, (RESAMPLES, len(ratios))), axis=1)
    low, high = np.percentile(medians, [2.5, 97.5])
    return float(low), float(high)


def _undisturbed(run: Callable[[], Sample]) -> Sample:
    sample = run()
    for _ in range(AGAIN):
        if sample.cpu_share >= BUSY:
            break
        sample = run()
    return sample


def timed_all(store: Store, records: Iterable[Record], report: Report, again: bool = False) -> dict[int, Record]:
    """Return each record, by its id, with its loop times; measured where the store holds none, or `again`."""
    scene_of = cache(lambda name, parameters: scenes.make(name, **dict(parameters)))
    placed = [(record, scene_of(record.scene, tuple(sorted(record.parameters.items())))) for record in records]
    result = {} if again else {id(record): stored_times(store, scene, record) for record, scene in placed}
    missing = [(record, scene) for record, scene in placed if result.get(id(record)) is None]
    with Isolated() as call:
        for done, (record, scene) in enumerate(missing):
            report(done, len(missing), f"timing {record.scene} {record.engine} {record.method}")
            result[id(record)] = measured(store, call, scene, record, again)
    return {key: record for key, record in result.items() if record is not None}


def timed(store: Store, call: Caller, scene: Scene, record: Record) -> Record:
    """Return the record of a successful run with loop times of an idle machine, measured where the store holds none."""
    if record.status != "success":
        return record
    loops = store.timings(_key(scene, record), machine())
    return with_loops(record, loops) if is_enough(loops) else measured(store, call, scene, record)


def stored_times(store: Store, scene: Scene, record: Record) -> Record | None:
    """Return the record with the times that the store holds of it on this machine; None where it holds none."""
    key = _key(scene, record)
    quiet = is_enough(loops := store.timings(key, machine()))
    loops = loops if quiet else store.timings(key, machine() + SHARED)
    return with_loops(record, loops, "" if quiet else BUSY_NOTE) if loops else None


def measured(store: Store, call: Caller, scene: Scene, record: Record, again: bool = False) -> Record:
    """Return the record with its loop times, which the store keeps; with a note where no run came back.

    Times that the store holds of an idle machine count, unless `again`.
    """
    held = [] if again else store.timings(_key(scene, record), machine())
    try:
        loops, share = call(time_loops, scene, record.engine, Settings(**record.settings), held)
    except (Lost, RuntimeError, ValueError, ArithmeticError) as error:
        return replace(record, notes=(*record.notes, f"not timed: {error}"))
    busy = share < BUSY
    store.keep_timings(_key(scene, record), machine() + (SHARED if busy else ""), loops)
    return with_loops(record, loops, BUSY_NOTE if busy else "")


def time_loops(scene: Scene, engine: str, settings: Settings, held: Sequence[float] = ()) -> tuple[list[float], float]:
    """Return the loop times (s), of which `held` are the first, and the share of a processor that the new runs got.

    A first run whose loop takes WARMED (0.2 s) or less warms caches up and is discarded.
    """
    made = [] if held else [one for one in [sample(scene, engine, settings)] if one.loop_s > WARMED]
    while not is_enough(loops := [*held, *(one.loop_s for one in made)]):
        made.append(sample(scene, engine, settings))
    return loops, float(np.mean([one.cpu_share for one in made] or [1.0]))


def sample(scene: Scene, engine: str, settings: Settings) -> Sample:
    """Return the time (s) of a run's loop, and the share of a processor that the run got."""
    solver, times = engines.get(engine), grid(scene)
    wall, cpu = time.perf_counter(), processor_time()
    loop = float(solver.run(scene, settings, times).timing.loop_s)
    return Sample(loop, (processor_time() - cpu) / max(time.perf_counter() - wall, 1e-9))


def is_enough(loops: list[float]) -> bool:
    """Whether the interval is narrow, or the bound on runs or on time is met."""
    if len(loops) < FEWEST_RUNS:
        return len(loops) == 1 and loops[0] > ENOUGH
    return len(loops) >= MOST_RUNS or half_width(loops) < NARROW or sum(loops) > ENOUGH


def half_width(loops: list[float]) -> float:
    """Return half of the spread of the loop times over their median; 0 where nothing was measured."""
    middle = float(np.median(loops))
    return 0.0 if middle <= 0.0 else 0.5 * (max(loops) - min(loops)) / middle


def _key(scene: Scene, record: Record) -> str:
    return run_name(scene, engines.get(record.engine), Settings(**record.settings), grid(scene))
