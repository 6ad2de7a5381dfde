"""Poses and velocities at t = 0 that are given in place of a scene's own."""

from __future__ import annotations

import numpy as np

from mbs_ref.cores.system import Poses
from mbs_ref.scene import Scene
from mbs_ref.scene.bodies import LARGEST_NORM_GAP


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
