"""DE421 (2008) and DE405 (1997, the Almanac's from 2003 on) from the packages de421 and de405."""

import importlib
import warnings
from functools import cache
from typing import Any

import numpy as np

KM = 1e3  # m


@cache
def _open(version: str) -> Any:
    from jplephem.ephem import Ephemeris  # pyright: ignore[reportMissingImports]  # an optional extra

    return Ephemeris(importlib.import_module(version))


def place(version: str, body: str, jd: float) -> np.ndarray:
    """Return the barycentric place (3,), m."""
    source = _open(version)
    if body in ("earth", "moon"):
        barycenter, moon = _position(source, "earthmoon", jd), _position(source, "moon", jd)  # the latter geocentric
        earth = barycenter - moon * source.earth_share
        return earth if body == "earth" else earth + moon
    return _position(source, body, jd)


def _position(source: Any, name: str, jd: float) -> np.ndarray:
    if name not in source.names:
        raise KeyError(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of the packaging, not of the data
        return np.asarray(source.position(name, jd)).ravel() * KM
