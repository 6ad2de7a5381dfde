"""Where poles, Moon and Sun point, in ICRF axes: the published series, whose tables are beside this file.

`d` (m,) is days of TDB from J2000; every direction is (m, 3).
"""

from collections.abc import Callable

import numpy as np

from cross_checks.truths.made_by.sky import PI, real
from mbs_ref import Scene
from mbs_ref.files import package_data
from mbs_ref.scene.celestial import DAY_S, J2000_JD, Epoch

CENTURY = 36_525  # days
OBLIQUITY = 84_381.406  # seconds of arc, of the ecliptic of J2000: IAU 2006

SERIES = {name: real(rows) for name, rows in package_data(__name__, "directions.toml").items()}


def date_of(scene: Scene) -> Callable[[np.ndarray], np.ndarray]:
    """Return what turns the scene's time (s) into days of TDB from J2000."""
    epoch = next((load.jd_tdb for load in scene.loads if isinstance(load, Epoch)), J2000_JD)
    start = real(epoch) - real(J2000_JD)
    return lambda t: start + t / real(DAY_S)


def earth_pole(d: np.ndarray) -> np.ndarray:
    """Return the celestial pole: precession and the 18.6-year nutation (IERS Conventions 2010, eq 5.16, 5.43)."""
    t = d / CENTURY
    node = _radians(real(125.04455501)) + _arcsec(real(-6_962_890.5431) * t)
    x = _arcsec(_series((-0.016617, 2004.191898, -0.4297829, -0.19861834), t) - real(6.844318) * np.sin(node))
    y = _arcsec(_series((-0.006951, -0.025896, -22.4072747, 0.00190059), t) + real(9.205236) * np.cos(node))
    return np.stack((x, y, np.sqrt(1 - x**2 - y**2)), axis=-1)


def moon_axes(d: np.ndarray) -> np.ndarray:
    """Return (m, 3, 3), rows the Moon's axes, x towards the Earth: R_z(W) R_x(90 deg - dec) R_z(90 deg + ra)."""
    t = d / CENTURY
    constant, rate = SERIES["moon_arguments"].T
    arguments = _radians(constant + np.outer(d, rate))
    sines, cosines = np.sin(arguments), np.cos(arguments)
    ascension = _series((269.9949, 0.0031), t) + sines @ SERIES["moon_right_ascension"]
    declination = _series((66.5392, 0.0130), t) + cosines @ SERIES["moon_declination"]
    meridian = _series((38.3213, 13.17635815, -1.4e-12), d) + sines @ SERIES["moon_meridian"]
    return _about_z(_radians(meridian)) @ _about_x(_radians(90 - declination)) @ _about_z(_radians(90 + ascension))


def sun_place(d: np.ndarray) -> np.ndarray:
    """Return the Sun seen from the Earth, m (Montenbruck and Gill 2000, eq 3.43 and 3.44)."""
    anomaly = _radians(_series((357.5256, 35_999.049), d / CENTURY))
    longitude = _radians(real(282.9400)) + anomaly + _arcsec(6892 * np.sin(anomaly) + 72 * np.sin(2 * anomaly))
    distance = real(149.619e9) - real(2.499e9) * np.cos(anomaly) - real(0.021e9) * np.cos(2 * anomaly)
    return _from_ecliptic(longitude, 0 * longitude, distance)


def moon_place(d: np.ndarray) -> np.ndarray:
    """Return the Moon seen from the Earth, m (Montenbruck and Gill 2000, eq 3.47 to 3.51)."""
    constant, rate = SERIES["mean_arguments"].T
    mean, *rest = _radians(constant + np.outer(d / CENTURY, rate)).T
    arguments = np.array(rest)  # l, l', F, D
    _, anomaly_of_sun, node_distance, _ = arguments
    shift = _sum(np.sin, "moon_longitude", arguments)
    inner = node_distance + _arcsec(shift + 412 * np.sin(2 * node_distance) + 541 * np.sin(anomaly_of_sun))
    latitude = 18_520 * np.sin(inner) + _sum(np.sin, "moon_latitude", arguments)
    distance = 1000 * _sum(np.cos, "moon_distance", arguments)
    return _from_ecliptic(mean + _arcsec(shift), _arcsec(latitude), distance)


def _sum(function: Callable, name: str, arguments: np.ndarray) -> np.ndarray:
    rows = SERIES[name]
    return rows[:, 0] @ function(rows[:, 1:] @ arguments)


def _series(coefficients: tuple[float, ...], t: np.ndarray) -> np.ndarray:
    return np.polynomial.polynomial.polyval(t, real(coefficients))


def _radians(degrees: np.ndarray) -> np.ndarray:
    return degrees * (PI / 180)


def _arcsec(seconds: np.ndarray) -> np.ndarray:
    return seconds * (PI / 648_000)


def _from_ecliptic(longitude: np.ndarray, latitude: np.ndarray, distance: np.ndarray) -> np.ndarray:
    flat = np.cos(latitude)
    seen = np.stack((flat * np.cos(longitude), flat * np.sin(longitude), np.sin(latitude)), axis=-1)
    return distance[:, None] * (seen @ _about_x(_arcsec(real(OBLIQUITY))))


def _about_x(angle: np.ndarray) -> np.ndarray:
    """Return the matrix that turns axes about x: R_x of Montenbruck and Gill 2000, eq A.1."""
    return np.roll(_about_z(angle), 1, axis=(-2, -1))


def _about_z(angle: np.ndarray) -> np.ndarray:
    c, s, one, none = np.cos(angle), np.sin(angle), np.ones_like(angle), np.zeros_like(angle)
    rows = (c, s, none), (-s, c, none), (none, none, one)
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
