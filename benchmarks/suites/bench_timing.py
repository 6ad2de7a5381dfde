"""The timing protocol itself: how often it cries wolf, and how often it finds the wolf."""

from __future__ import annotations

import time

import numpy as np

from cross_checks.prices.timing import Pace, Sample, compare
from mbs_ref.kernels.jit import jit

IDENTICAL, SLOWED = 40, 20  # comparisons
WORK = 200_000  # turns of the loop, about a millisecond


@jit
def spin(turns):
    total = 0.0
    for k in range(turns):
        total += np.sin(total + k)
    return total


def timed(turns: int):
    def run() -> Sample:
        wall, cpu = time.perf_counter(), time.process_time()
        spin(turns)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        return Sample(wall, cpu / wall)

    return run


def test_false_alarms_and_found_slowdowns(benchmark):
    spin(1)
    paces: dict[str, list[Pace]] = {}

    def measure():
        paces["same"] = [compare(timed(WORK), timed(WORK), seed).pace for seed in range(IDENTICAL)]
        paces["slower"] = [compare(timed(WORK), timed(WORK * 11 // 10), seed).pace for seed in range(SLOWED)]

    benchmark.pedantic(measure, rounds=1)
    alarms = sum(pace in (Pace.SLOWER, Pace.FASTER) for pace in paces["same"])
    hits = paces["slower"].count(Pace.SLOWER)
    benchmark.extra_info |= {"false_alarms": f"{alarms}/{IDENTICAL}", "found": f"{hits}/{SLOWED}"}
    print(f"false alarms {alarms} of {IDENTICAL}, +10 % found {hits} of {SLOWED}")
    assert alarms < 0.05 * IDENTICAL
    assert hits >= 0.9 * SLOWED
