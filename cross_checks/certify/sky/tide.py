"""The tide that one body raises on another, with a constant lag."""

from __future__ import annotations

import numpy as np

from cross_checks.certify.numerics.jet import Jet, lift
from cross_checks.certify.sky.numbers import Field, masses, norm, real
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import Tide


def lagging_tide(scene: Scene, load: Tide) -> Field:
    """Return the pull of the bulge that the raiser raised one lag ago, to first order in the lag.

    The bulge is carried on by the body's spin: it points to r* = r - lag (v - spin x r), and its potential at r is
    k2 gm R^5 [3 (r.r*)^2 - r^2 r*^2] / (2 r^5 r*^5) (Mignard, Moon and Planets 20 (1979) 301, eq 2 and 4).
    The derivative by the lag is taken by a jet.
    """
    i, j, gm = scene.body_index(load.body), scene.body_index(load.raiser), masses(scene)
    love, lag, spin, radius = real(load.love_number), real(load.lag), real(load.spin), real(load.radius)

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        r, rate = x[:, j] - x[:, i], v[:, j] - v[:, i]
        raised = Jet(r, -(rate - np.cross(spin, r)), 0 * r)
        gradient = _gradient(r, raised)
        force = love * gm[j] * radius**5 * (gradient.value + lag * gradient.first)  # on the raiser, per its gm
        pull = np.zeros_like(x)
        pull[:, j] = force
        pull[:, i] = -force * gm[j] / gm[i]
        return pull

    return field


def _gradient(r: np.ndarray, raised: Jet) -> Jet:
    """Return the gradient by r of [3 (r.r*)^2 - r^2 r*^2] / (2 r^5 r*^5)."""
    distance = norm(r)
    along, square = _dot(lift(r), raised), _dot(raised, raised)
    falling = _power(square, -2.5) * (0.5 / distance**5)
    shape = 3 * along * along - square * distance**2
    return falling * (6 * along * raised - 2 * square * r - 5 * shape * (r / distance**2))


def _dot(a: Jet, b: Jet) -> Jet:
    product = a * b
    return Jet(*(np.sum(part, axis=-1, keepdims=True) for part in (product.value, product.first, product.second)))


def _power(a: Jet, n: float) -> Jet:
    slope, bend = n * a.value ** (n - 1), n * (n - 1) * a.value ** (n - 2)
    return Jet(a.value**n, slope * a.first, slope * a.second + bend * a.first**2)
