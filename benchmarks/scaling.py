"""How long the matrix would take on more cores, from the measured times of its tasks."""

from __future__ import annotations

import heapq
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cross_checks.records.lines import read
from cross_checks.records.record import Record

CORES = (1, 2, 8, 32, 128, 1000)
SCHEDULING = 1e-3  # s a task, of the one scheduler process (dask.distributed's documentation: up to 1 ms)


@dataclass(frozen=True)
class Scaling:
    """The matrix on a number of cores."""

    cores: int
    seconds: float  # of list scheduling, or of the scheduler itself where that is longer
    speedup: float
    efficiency: float  # speedup over cores


def task_seconds(records: Iterable[Record]) -> list[float]:
    """Return what each task costs a core (s): its processor time, which a busy machine stretches little."""
    timed = [record.times for record in records if "task_s" in record.times]
    return [times.get("cpu_s", times["task_s"]) for times in timed]


def makespan(seconds: Sequence[float], cores: int) -> float:
    """Return the time (s) of list scheduling, the longest first: within 4/3 of the best (Graham 1969)."""
    free = [0.0] * cores
    for task in sorted(seconds, reverse=True):
        heapq.heapreplace(free, free[0] + task)
    return max(free)


def scaling(seconds: Sequence[float], cores: int) -> Scaling:
    """Return what `cores` would do; one scheduler hands out the tasks."""
    took = max(makespan(seconds, cores), SCHEDULING * len(seconds))
    faster = sum(seconds) / took
    return Scaling(cores, took, faster, faster / cores)


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python -m benchmarks.scaling MATRIX.jsonl")
    records, problems = read(Path(sys.argv[1]))
    print("\n".join(problems), file=sys.stderr)
    seconds = sorted(task_seconds(records))
    if not seconds:
        sys.exit("no record holds the time of its task; make them with: mbs-ref matrix -o MATRIX.jsonl")
    half, longest = seconds[len(seconds) // 2], seconds[-1]
    print(f"{len(seconds)} tasks, {sum(seconds):.1f} s in all, median {half:.3f} s, the longest {longest:.1f} s")
    for cores in CORES:
        scaled = scaling(seconds, cores)
        gain = f"{scaled.speedup:7.1f} times faster, {scaled.efficiency:4.0%} used"
        print(f"{cores:5d} cores: {scaled.seconds:9.2f} s, {gain}")


if __name__ == "__main__":
    main()
