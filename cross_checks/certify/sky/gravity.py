"""Newton's attraction among all bodies."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.sky.numbers import Field, masses
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import Newton


def newton(scene: Scene, load: Newton) -> Field:
    """Return sum_j gm_j (x_j - x_i) / r_ij^3."""
    gm = masses(scene)

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        apart, distance = separations(x)
        return np.sum(gm / distance**3 * apart, axis=2)

    return field


def separations(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x_j - x_i as [:, i, j, :], and its length [:, i, j, 1]: infinite where i is j."""
    apart = x[:, None, :, :] - x[:, :, None, :]
    square = np.sum(apart**2, axis=-1, keepdims=True)
    one = np.arange(x.shape[1])
    square[:, one, one] = np.inf
    return apart, np.sqrt(square)
