"""How long the matrix would take on more cores, from the measured times of its tasks."""

from __future__ import annotations

import heapq
import sys
from collections.abc import Sequence
from pathlib import Path

from cross_checks.record_file import read

CORES = (1, 2, 8, 32, 128, 1000)


def makespan(seconds: Sequence[float], cores: int) -> float:
    """Return the time (s) of list scheduling, the longest first: within 4/3 of the best (Graham 1969)."""
    free = [0.0] * cores
    for task in sorted(seconds, reverse=True):
        heapq.heapreplace(free, free[0] + task)
    return max(free)


def main() -> None:
    records, problems = read(Path(sys.argv[1]))
    print("\n".join(problems), file=sys.stderr)
    seconds = [r.times["task_s"] for r in records if "task_s" in r.times]
    if not seconds:
        sys.exit("no record holds the time of its task")
    print(f"{len(seconds)} tasks, {sum(seconds):.1f} s in all, the longest {max(seconds):.1f} s")
    for cores in CORES:
        took = makespan(seconds, cores)
        print(f"{cores:5d} cores: {took:9.2f} s, {sum(seconds) / took:7.1f} times faster")


if __name__ == "__main__":
    main()
