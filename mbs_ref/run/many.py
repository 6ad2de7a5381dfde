"""Many runs in one call: shared among threads, from starts that fit the scene.

Compiled loops of DOP853, Radau, Gauss-Legendre and generalized-alpha let other threads go on.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from mbs_ref.cores.system import Poses
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
    none = Poses(*(np.zeros((0, *shape)) for shape in _shapes(scene)))
    return Trajectory(np.zeros(0), **none._asdict(), status=status, message=message)


def _shapes(scene: Scene) -> tuple[tuple[int, ...], ...]:
    """Return the shapes of position, orientation, velocity and angular velocity of all bodies at one time."""
    n, space = len(scene.bodies), scene.dimension == 3
    return (n, scene.dimension), (n, 4) if space else (n,), (n, scene.dimension), (n, 3) if space else (n,)


def check_shapes(scene: Scene, starts: Poses) -> None:
    """Raise ValueError where starts are not n poses and velocities of all bodies."""
    for name, given, shape in zip(Poses._fields, starts, _shapes(scene), strict=True):
        wanted = (len(starts.position), *shape)
        if np.shape(given) != wanted:
            raise ValueError(f"starts.{name} has the shape {np.shape(given)}; allowed: {wanted}")
        if not np.all(np.isfinite(given)):
            raise ValueError(f"starts.{name} holds an infinite number or NaN; allowed: finite ones")
