"""What moves celestial bodies, written from the literature in extended precision.

It shares with the solver the words and numbers of `mbs_ref.scene.celestial`, and no code: these are what its
kernels are judged by. Times are s from the scene's epoch, shape (m,); places and rates are (m, n_bodies, 3) in m
and m/s along ICRF axes; a field returns accelerations of that shape, m/s^2. Everything is `numpy.longdouble`.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from mbs_ref import Scene
from mbs_ref.scene.scales import attraction

Field = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]  # (t, x, v) -> acceleration
PI = np.arccos(np.longdouble(-1))


def real(values: Any) -> np.ndarray:
    """Return values in extended precision."""
    return np.array(values, dtype=np.longdouble)


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return products of vectors along the last axis, which remains."""
    return np.vecdot(a, b)[..., None]


def norm(a: np.ndarray) -> np.ndarray:
    """Return lengths of vectors along the last axis, which remains."""
    return np.sqrt(dot(a, a))


def masses(scene: Scene) -> np.ndarray:
    """Return gm of every body as a column (n_bodies, 1), m^3/s^2."""
    return real(attraction(scene))[:, None]


def with_reaction(scene: Scene, body: str, field: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Field:
    """Return what one body's field (t, r) -> per gm does to all others, and they, by reaction, to it."""
    i, gm = scene.body_index(body), masses(scene)
    others = [j for j in range(len(gm)) if j != i]

    def acts(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        each = field(t, x[:, others] - x[:, i : i + 1])
        pull = np.zeros_like(x)
        pull[:, others] = gm[i] * each
        pull[:, i] = -np.sum(gm[others] * each, axis=1)
        return pull

    return acts
