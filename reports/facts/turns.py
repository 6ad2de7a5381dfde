"""Times that are compared with one another: least of runs in randomly interleaved turns."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

ROUNDS = 3  # turns, of which a run's least counts
ENOUGH = 1.0  # s of a loop that takes one turn alone: a scheduler's quanta are small beside it


def least_times(runs: Sequence[Callable[[], float]], first: Sequence[float]) -> list[float]:
    """Return the least time (s) of each run, which returns its own; `first` (s) tells roughly how long each is."""
    best = [np.inf] * len(runs)
    random = np.random.default_rng(0)
    for turn in range(ROUNDS):
        for k in random.permutation([k for k, seconds in enumerate(first) if turn == 0 or seconds <= ENOUGH]):
            best[k] = min(best[k], runs[k]())
    return best
