"""Times that are compared with one another: least of runs in randomly interleaved turns."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.loop_times import ENOUGH

ROUNDS = 3  # turns, of which a run's least counts


def least_times(runs: Sequence[Callable[[], float]], first: Sequence[float], alone: bool = False) -> list[float]:
    """Return the least time (s) of each run, which returns its own; `first` (s) tells roughly how long each is.

    A run of more than ENOUGH seconds takes one turn: a scheduler's quanta are small beside it. What was timed
    first with the machine to itself, `alone`, is the first turn.
    """
    best = list(first) if alone else [np.inf] * len(runs)
    random = np.random.default_rng(0)
    for turn in range(int(alone), ROUNDS):
        for k in random.permutation([k for k, seconds in enumerate(first) if turn == 0 or seconds <= ENOUGH]):
            best[k] = min(best[k], runs[k]())
    return best
