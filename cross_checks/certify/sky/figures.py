"""Bodies that are no points: zonal harmonics and the Moon's second-degree field, as gradients of potentials."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cross_checks.certify.sky import directions
from cross_checks.certify.sky.numbers import Field, dot, norm, real, with_reaction
from mbs_ref.scene import Scene
from mbs_ref.scene.celestial import LunarFigure, Oblateness


def zonal_harmonics(scene: Scene, load: Oblateness) -> Field:
    """Return the field of the potential -gm/r sum J_n (R/r)^n P_n(s), s the sine of the latitude.

    Its gradient is taken along the radius and along the meridian (Montenbruck and Gill 2000, sec. 3.2.1).
    """
    pole = _pole(scene, load)
    polynomials = [np.polynomial.legendre.leg2poly([0] * n + [1]) for n in range(2, len(load.zonal) + 2)]
    radius, zonal = real(load.radius), real(load.zonal)

    def field(t: np.ndarray, r: np.ndarray) -> np.ndarray:
        axis, distance = pole(t)[:, None], norm(r)
        up = r / distance
        s = dot(up, axis)
        pull = np.zeros_like(r)
        for n, (harmonic, p) in enumerate(zip(zonal, polynomials, strict=True), start=2):
            value = _polynomial(p, s)
            slope = _polynomial(p[1:] * np.arange(1, n + 1), s)
            pull += harmonic * (radius / distance) ** n * ((n + 1) * value * up - slope * (axis - s * up))
        return pull / distance**2

    return with_reaction(scene, load.body, field)


def _polynomial(coefficients: np.ndarray, s: np.ndarray) -> np.ndarray:
    return np.polynomial.polynomial.polyval(s, coefficients.astype(s.dtype))


def _pole(scene: Scene, load: Oblateness) -> Callable[[np.ndarray], np.ndarray]:
    """Return t -> unit vector (m, 3)."""
    if load.pole == "earth_iau2006":
        date = directions.date_of(scene)
        return lambda t: directions.earth_pole(date(t))
    axis = real(load.axis)
    return lambda t: np.broadcast_to(axis, (len(t), 3))


def lunar_figure(scene: Scene, load: LunarFigure) -> Field:
    """Return the field of the potential gm r.Q.r / r^5 with Q the trace-free quadrupole, turned by the Moon."""
    date, j2, c22 = directions.date_of(scene), real(load.j2), real(load.c22)
    own = real(load.radius) ** 2 * np.diag([j2 / 2 + 3 * c22, j2 / 2 - 3 * c22, -j2])

    def field(t: np.ndarray, r: np.ndarray) -> np.ndarray:
        axes = directions.moon_axes(date(t))  # rows are the Moon's axes
        quadrupole = np.swapaxes(axes, 1, 2) @ own @ axes
        turned, distance = r @ quadrupole, norm(r)
        return 2 * turned / distance**5 - 5 * dot(r, turned) * r / distance**7

    return with_reaction(scene, load.body, field)
