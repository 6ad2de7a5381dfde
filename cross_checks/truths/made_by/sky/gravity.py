"""Gravity of points, rings and bodies that are no points: Newton's, post-Newtonian, zonal, lunar and tidal."""

from collections.abc import Callable

import numpy as np

from cross_checks.truths.made_by.numerics.jet import Jet, lift
from cross_checks.truths.made_by.sky import PI, Field, directions, dot, masses, norm, real, with_reaction
from mbs_ref import Scene
from mbs_ref.scene.celestial import LunarFigure, Newton, Oblateness, Relativity, Ring, Tide


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


BETA = GAMMA = 1  # general relativity's


def post_newtonian(scene: Scene, load: Relativity) -> Field:
    """Return what relativity adds to Newton's attraction."""
    return _all_bodies(scene, load) if load.form == "eih" else _first_body(scene, load)


def _all_bodies(scene: Scene, load: Relativity) -> Field:
    """The point-mass equation of Newhall, Standish and Williams, Astron. Astrophys. 125 (1983) 150, eq 1.

    Its accelerations a_j are Newton's, which is all that matters to this order.
    """
    gm, c2 = masses(scene), real(load.c) ** 2
    attraction = newton(scene, Newton(name="newton", gm=tuple(float(m) for m in gm[:, 0])))

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        apart, r = separations(x)  # r_j - r_i
        potential = np.sum(gm / r, axis=2)  # at every body, of all others
        a = attraction(t, x, v)
        vi, vj, aj = v[:, :, None], v[:, None], a[:, None]
        toward = dot(apart, vj)
        brackets = (
            (-2 * (BETA + GAMMA) * potential + GAMMA * dot(v, v))[:, :, None]
            + (-(2 * BETA - 1) * potential + (1 + GAMMA) * dot(v, v))[:, None]
            - 2 * (1 + GAMMA) * dot(vi, vj)
            - (toward / r) ** 2 * 3 / 2
            + dot(apart, aj) / 2
        )
        moving = -(2 + 2 * GAMMA) * dot(apart, vi) + (1 + 2 * GAMMA) * toward
        terms = gm / r**3 * (apart * brackets + moving * (vi - vj)) + (3 + 4 * GAMMA) * gm / (2 * r) * aj
        return np.sum(terms, axis=2) / c2

    return field


def _first_body(scene: Scene, load: Relativity) -> Field:
    """The Schwarzschild terms of IERS Conventions 2010, eq 10.12, without a reaction."""
    gm, c2 = masses(scene)[0], real(load.c) ** 2

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        r, rate = x[:, 1:] - x[:, :1], v[:, 1:] - v[:, :1]
        distance = norm(r)
        static = (2 * (BETA + GAMMA) * gm / distance - GAMMA * dot(rate, rate)) * r
        moving = 2 * (1 + GAMMA) * dot(r, rate) * rate
        pull = np.zeros_like(x)
        pull[:, 1:] = gm / (c2 * distance**3) * (static + moving)
        return pull

    return field


def fixed_ring(scene: Scene, load: Ring) -> Field:
    """Return the attraction of the ring's masses, on which nothing acts back."""
    places, share = _ring_places(load), real(load.gm) / load.count

    def field(t: np.ndarray, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        apart = places - x[:, :, None]
        return np.sum(share * apart / norm(apart) ** 3, axis=2)

    return field


def _ring_places(load: Ring) -> np.ndarray:
    """Return (count, 3), m: turned about the normal from the axis that lies most across it."""
    normal = real(load.normal)
    normal = normal / norm(normal)
    across = np.zeros(3, dtype=np.longdouble)
    across[np.argmin(np.abs(normal))] = 1
    first = np.cross(normal, across)
    first = first / norm(first)
    angle = 2 * PI * np.arange(load.count)[:, None] / load.count
    return real(load.radius) * (first * np.cos(angle) + np.cross(normal, first) * np.sin(angle))


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
    along, square = _jet_dot(lift(r), raised), _jet_dot(raised, raised)
    falling = _power(square, -2.5) * (0.5 / distance**5)
    shape = 3 * along * along - square * distance**2
    return falling * (6 * along * raised - 2 * square * r - 5 * shape * (r / distance**2))


def _jet_dot(a: Jet, b: Jet) -> Jet:
    product = a * b
    return Jet(*(np.sum(part, axis=-1, keepdims=True) for part in (product.value, product.first, product.second)))


def _power(a: Jet, n: float) -> Jet:
    slope, bend = n * a.value ** (n - 1), n * (n - 1) * a.value ** (n - 2)
    return Jet(a.value**n, slope * a.first, slope * a.second + bend * a.first**2)
