"""Frames, light time, clocks and velocities by short formulas, compared with Astropy's complete ones."""

import time
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from mbs_ref import Settings, ephemeris, scenes
from mbs_ref.files import package_data
from mbs_ref.scene.celestial import C_SI
from mbs_ref.simulate import simulate
from reports.facts.curves import Row

START, J2000, DAY, CENTURY = 2_450_814.5, 2_451_545.0, 86_400.0, 36_525.0  # JD TDB, JD TDB, s, days
TAI_UTC = 31.0  # s, then
ARC = np.radians(1.0 / 3600.0)  # rad
SERIES = package_data(__name__, "frames.toml")
TRACKS = (("rotation angle alone", 0, False), ("and precession", 1, False), ("and four terms of nutation", 2, False),
          ("and UT1 - UTC", 2, True))  # fmt: skip
STATION, MASK = (np.radians(11.28), np.radians(48.09)), np.radians(10.0)  # longitude, latitude; least elevation, rad
EQUATOR, OBLATE = 6_378_137.0, 1.0 / 298.257223563  # m, 1: WGS 84
PLANETS = ("mercury", "venus", "earth", "mars", "jupiter", "saturn", "uranus", "neptune")


def comparisons() -> tuple[Row, ...]:
    """Return a row for each comparison: largest distance, significant figures, both times (s); none without Astropy."""
    try:
        return tuple(_rows(import_module("cross_checks.ephemerides.astropy_")))
    except ModuleNotFoundError:
        return ()


def by_sgp4() -> tuple[Row, ...]:
    """Return by orbit how far (m) SGP4 departs from our run of the zonal field; nothing without its package."""
    rows: list[Row] = []
    for orbit in ("leo", "sun_synchronous", "gps") if find_spec("sgp4") else ():
        scene = scenes.make("satellite", orbit=orbit, days=7.0, zonals=True)
        path = simulate(scene, Settings(rtol=1e-10, samples=1009, estimate="off"))
        place, rate, sgp4_ = path.position[:, 1], path.velocity[0, 1], import_module("cross_checks.ephemerides.sgp4_")
        apart = np.linalg.norm(sgp4_.propagated(place[0], rate, path.times) - place, axis=1)
        rows.append({"orbit": orbit} | {f"after_{hours}": float(apart[6 * hours]) for hours in (1, 24, 168)})
    return tuple(rows)


def _rows(astropy: Any) -> Iterator[Row]:
    path = simulate(scenes.make("satellite", orbit="leo", days=1.0), Settings(rtol=1e-10, samples=289, estimate="off"))
    places, jds = path.position[:, -1] - path.position[:, 0], START + path.times / DAY
    tdb_utc, ut1_utc = astropy.clocks(START)
    for name, level, shifted in TRACKS:
        ut1 = jds - (tdb_utc - ut1_utc * shifted) / DAY
        yield _row(
            f"ground track of a satellite, ITRS: {name}", "m",
            lambda ut1=ut1, level=level: turned(places, ut1, level, 1.0), lambda: astropy.in_frame("ITRS", places, jds),
        )  # fmt: skip
    yield _row("the same satellite in TEME, SGP4's frame", "m", lambda: turned(places, jds, 2, 0.0),
               lambda: astropy.in_frame("TEME", places, jds))  # fmt: skip
    ut1 = jds - (tdb_utc - ut1_utc) / DAY
    yield _row("rise and set of that satellite above 10 degrees at a station", "s",
               lambda: passes(elevations(turned(places, ut1, 2, 1.0), *STATION), path.times),
               lambda: passes(astropy.elevations(places, jds, *STATION), path.times))  # fmt: skip
    source = "astropy_de440" if ephemeris.is_complete() else "astropy_builtin"
    for name, steps, moving in (("geometric", 0, False), ("light time", 4, False), ("and aberration", 4, True)):
        yield _row(
            f"Mars from the Earth: {name}", "m",
            lambda steps=steps, moving=moving: seen(astropy, source, "mars", START, steps, moving),
            lambda: astropy.apparent(source, "mars", START),
        )  # fmt: skip
    yield _row(
        "velocities of the planets: DE440", "m/s",
        lambda: np.array([ephemeris.state(body, START)[1] for body in PLANETS]),
        lambda: np.array([astropy.velocity(source, body, START) for body in PLANETS]),
    )  # fmt: skip
    periodic = 0.001658 * np.sin(np.radians(357.53 + 0.98560028 * (START - J2000)))  # s, largest term of TDB - TT
    yield _row("TDB - UTC", "s", lambda: np.array([TAI_UTC + 32.184 + periodic]),
               lambda: np.array(astropy.clocks(START)[:1]))  # fmt: skip


def _row(name: str, unit: str, ours: Callable[[], np.ndarray], theirs: Callable[[], np.ndarray]) -> Row:
    (one, ours_s), (other, theirs_s) = _timed(ours), _timed(theirs)
    gap, size = (np.linalg.norm(np.atleast_2d(x), axis=1) for x in (one - other, other))
    figures = float(-np.log10(max(np.max(gap / size), np.finfo(float).eps)))
    apart = float(gap.max())
    return {"name": name, "unit": unit, "apart": apart, "figures": figures, "ours_s": ours_s, "theirs_s": theirs_s}


def _timed(call: Callable[[], np.ndarray]) -> tuple[np.ndarray, float]:
    """Return a result, and the time (s) of the second call: the first one reads files."""
    call()
    began = time.perf_counter()
    return call(), time.perf_counter() - began


def seen(astropy: Any, source: str, body: str, jd: float, steps: int, moving: bool) -> np.ndarray:
    """Return the place (3,), m, of a body from the Earth's centre: at its light's start after `steps` iterations.

    For an observer that moves with the Earth it is turned by aberration (Explanatory Supplement 2013, eq. 7.40).
    """
    here, there = (astropy.place(source, name, jd) for name in ("earth", body))
    for _ in range(steps):
        there = astropy.place(source, body, jd - np.linalg.norm(there - here) / C_SI / DAY)
    distance = float(np.linalg.norm(there - here))
    u, beta = (there - here) / distance, moving * astropy.velocity(source, "earth", jd) / C_SI
    shrink, along = np.sqrt(1.0 - beta @ beta), u @ beta
    return distance * (shrink * u + (1.0 + along / (1.0 + shrink)) * beta) / (1.0 + along)


def turned(places: np.ndarray, ut1: np.ndarray, level: int, turn: float) -> np.ndarray:
    """Return places (n, 3), m, of GCRS axes as the Earth sees them at Julian dates UT1; in TEME with turn = 0.

    From level 1 with precession, from level 2 with nutation (IERS Conventions 2010, ch. 5, without polar motion).
    """
    since = ut1 - J2000
    t = since / CENTURY
    gamma, phi, psi, eps = (ARC * (a + b * t + c * t * t) * (level > 0) for a, b, c in SERIES["precession"])
    angles = [np.radians(a + b * t) for a, b, _, _ in SERIES["nutation"]]
    dpsi, deps = (
        ARC * (level > 1) * sum(term[k] * f(x) for x, term in zip(angles, SERIES["nutation"], strict=True))
        for k, f in ((2, np.sin), (3, np.cos))
    )
    angle = 2.0 * np.pi * (0.7790572732640 + 1.00273781191135448 * since)
    sidereal = angle + ARC * np.polynomial.polynomial.polyval(t, SERIES["sidereal"]) * (level > 0)
    place = _about("x", -eps - deps, _about("z", -psi - dpsi, _about("x", phi, _about("z", gamma, places))))
    return _about("z", turn * sidereal + dpsi * np.cos(eps), place)


def elevations(places: np.ndarray, longitude: float, latitude: float) -> np.ndarray:
    """Return the elevations (n,), rad, of places (n, 3), m, in axes of the Earth, from a station on its ellipsoid."""
    c, s = np.cos(latitude), np.sin(latitude)
    up = np.array([c * np.cos(longitude), c * np.sin(longitude), s])
    flat = np.array([1.0, 1.0, (1.0 - OBLATE) ** 2])
    seen = places - EQUATOR * flat * up / np.sqrt(flat @ up**2)
    return np.arcsin(seen @ up / np.linalg.norm(seen, axis=1))


def passes(elevation: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return when (n, 1), s, an elevation (n_t,), rad, crosses MASK, by the cubic spline through its samples."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(times, elevation - MASK).roots(extrapolate=False)[:, None]


def _about(axis: str, angle: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return components (n, 3) in axes turned by an angle (n,), rad, about x or z."""
    return Rotation.from_euler(axis, -angle[:, None]).apply(places)
