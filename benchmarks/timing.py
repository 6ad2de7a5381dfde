"""Which of two timed things is faster: randomly interleaved pairs, minimum over blocks, bootstrap interval."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from statistics import median
from typing import NamedTuple

import numpy as np

from cross_checks.records.record import Record

PAIRS = 5  # runs of each in a block, of which the fastest counts
LEAST, MOST = 10, 40  # blocks
LIMIT = 1.05  # a ratio of times within 1/LIMIT and LIMIT is the same
RESAMPLES = 1000
BUSY = 0.9  # of a processor: with less, a run shares the machine
BUSY_NOTE = "timed on a busy machine"
AGAIN = 3  # times a disturbed run is made again


class Sample(NamedTuple):
    """One timed run."""

    loop_s: float
    cpu_share: float = 1.0  # of a processor, while it ran


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
    disturbed: float  # share of runs that shared the machine, though they were made again


def with_loops(record: Record, loops: Sequence[float], note: str = "") -> Record:
    """Return the record with its loop times (s): the least, the median, the largest; `note` is added to its notes."""
    times = {"loop_s": min(loops), "loop_median_s": median(loops), "loop_most_s": max(loops)}
    notes = (*record.notes, note) if note else record.notes
    return replace(record, times=record.times | times | {"loop_runs": float(len(loops))}, notes=notes)


def compare(
    first: Callable[[], Sample], second: Callable[[], Sample], seed: int = 0, limit: float = LIMIT
) -> Comparison:
    """Time both until the verdict is clear or MOST blocks are spent; ratios within 1/limit and limit are the same."""
    random = np.random.default_rng(seed)
    ratios: list[float] = []
    disturbed = 0
    while True:
        before, after, noise = _block(first, second, random)
        ratios.append(after / before)
        disturbed += noise
        if len(ratios) < LEAST:
            continue
        low, high = interval(np.array(ratios), random)
        ratio = float(np.median(ratios))
        pace = verdict(ratio, low, high, limit)
        if pace is not Pace.INCONCLUSIVE or len(ratios) == MOST:
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


def _block(first: Callable[[], Sample], second: Callable[[], Sample], random: np.random.Generator):
    best, disturbed = [np.inf, np.inf], 0
    for _ in range(PAIRS):
        for which in random.permutation(2):
            sample = _undisturbed((first, second)[which])
            best[which] = min(best[which], sample.loop_s)
            disturbed += sample.cpu_share < BUSY
    return best[0], best[1], disturbed


def _undisturbed(run: Callable[[], Sample]) -> Sample:
    sample = run()
    for _ in range(AGAIN):
        if sample.cpu_share >= BUSY:
            break
        sample = run()
    return sample
