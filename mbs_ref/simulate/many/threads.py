"""Run many pieces of work in threads. Compiled loops of DOP853, Radau, Gauss and generalized-alpha release the GIL."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from mbs_ref.kernels.algebra.lanes import WIDTH

MAX_NUMBERS = 4_000_000  # entries of states in one piece of work: 32 MB
PIECES = 4  # pieces of work for each thread, which balances the threads
ROUNDS = 8  # least number of runs of a lane in a piece; lanes are idle at the end of a piece


def processors(threads: int | None) -> int:
    """Return the number of threads: the number of processors unless given."""
    return threads or len(os.sched_getaffinity(0))


def pieces(count: int, threads: int, numbers: int) -> list[slice]:
    """Divide `count` runs, with so many `numbers` of states each, into pieces of work for threads."""
    even = max(ROUNDS * WIDTH, -(-count // (PIECES * threads)))
    most = max(WIDTH, MAX_NUMBERS // (2 * numbers))
    size = min(even, most)
    return [slice(k, min(k + size, count)) for k in range(0, count, size)]


def shared[T, R](run: Callable[[T], R], work: list[T], threads: int | None, alone: int = 1) -> list[R]:
    """Return the result of each piece of work; the first `alone` pieces run first, because they compile.

    Ctrl-C cancels the remaining pieces.
    """
    first = [run(piece) for piece in work[:alone]]
    with ThreadPoolExecutor(processors(threads)) as pool:
        later = [pool.submit(run, piece) for piece in work[alone:]]
        try:
            return first + [one.result() for one in later]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
