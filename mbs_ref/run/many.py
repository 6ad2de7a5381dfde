"""Many runs in one call, shared among threads, and the poses and velocities at t = 0 that they are given.

Compiled loops of DOP853, Radau, Gauss-Legendre and generalized-alpha let other threads go on.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene
from mbs_ref.scene.bodies import LARGEST_NORM_GAP
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


def shapes(scene: Scene) -> tuple[tuple[int, ...], ...]:
    """Return the shapes of position, orientation, velocity and angular velocity of all bodies at one time."""
    n, space = len(scene.bodies), scene.dimension == 3
    return (n, scene.dimension), (n, 4) if space else (n,), (n, scene.dimension), (n, 3) if space else (n,)


def check_starts(scene: Scene, starts: Poses, count: int | None = None) -> None:
    """Raise ValueError where starts are not poses and velocities of all bodies: shapes, finite numbers, norms of 1.

    There are to be `count` of each, or any number.
    """
    count = len(starts.position) if count is None else count
    for name, given, shape in zip(Poses._fields, starts, shapes(scene), strict=True):
        wanted = (count, *shape)
        if np.shape(given) != wanted:
            raise ValueError(f"starts.{name} has the shape {np.shape(given)}; allowed: {wanted}")
        if not np.all(np.isfinite(given)):
            raise ValueError(f"starts.{name} holds an infinite number or NaN; allowed: finite ones")
    if scene.dimension == 3:
        _check_norms(scene, np.asarray(starts.orientation))


def _check_norms(scene: Scene, orientation: np.ndarray) -> None:
    gaps = np.abs(np.sum(orientation**2, axis=-1) - 1.0)
    if not np.any(gaps > LARGEST_NORM_GAP):
        return
    start, body = np.unravel_index(np.argmax(gaps), gaps.shape)
    theta = orientation[start, body]
    raise ValueError(
        f"starts.orientation[{start}] of body {scene.bodies[body].name!r} = {theta.tolist()} has the norm "
        f"{np.linalg.norm(theta):.12g}; Euler parameters have 1"
    )
