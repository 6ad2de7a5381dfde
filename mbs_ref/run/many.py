"""Many runs in one call, shared among threads.

Compiled loops of DOP853, Radau, Gauss-Legendre and generalized-alpha let other threads go on.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.run.starts import shapes
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Status, Trajectory


def processors(threads: int | None) -> int:
    """Return how many threads to run: the number of processors unless given."""
    return threads or len(os.sched_getaffinity(0))


def shared[T, R](run: Callable[[T], R], work: list[T], threads: int | None, alone: int = 1) -> list[R]:
    """Return what each piece of work gives; the first is done `alone`, because it compiles. Ctrl-C ends the rest."""
    first = [run(piece) for piece in work[:alone]]
    with ThreadPoolExecutor(processors(threads)) as pool:
        later = [pool.submit(run, piece) for piece in work[alone:]]
        try:
            return first + [one.result() for one in later]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def stopped(scene: Scene, status: Status, message: str) -> Trajectory:
    """Return a trajectory without samples."""
    none = Poses(*(np.zeros((0, *shape)) for shape in shapes(scene)))
    return Trajectory(np.zeros(0), **none._asdict(), status=status, message=message)
