"""A ring of equal fixed masses."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.sky.numbers import PI, Field, norm, real
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import Ring


def fixed_ring(scene: Scene, load: Ring) -> Field:
    """Return the attraction of the ring's masses, on which nothing acts back."""
    places, share = _places(load), real(load.gm) / load.count

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        apart = places - x[:, :, None]
        return np.sum(share * apart / norm(apart) ** 3, axis=2)

    return field


def _places(load: Ring) -> np.ndarray:
    """Return (count, 3), m: turned about the normal from the axis that lies most across it."""
    normal = real(load.normal)
    normal = normal / norm(normal)
    across = np.zeros(3, dtype=np.longdouble)
    across[np.argmin(np.abs(normal))] = 1
    first = np.cross(normal, across)
    first = first / norm(first)
    angle = 2 * PI * np.arange(load.count)[:, None] / load.count
    return real(load.radius) * (first * np.cos(angle) + np.cross(normal, first) * np.sin(angle))
