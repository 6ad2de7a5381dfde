"""Ephemerides to compare with DE440, and their spread: one adapter file <source>_.py a source.

An adapter offers place(version, body, jd): the barycentric position (3,), m, with ICRF axes, at a Julian date
TDB; KeyError where the version has no such body. Nobody else imports its package. Where a package is absent, a
committed excerpt answers for the dates it holds.
"""

import importlib
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from cross_checks.truths import is_unchanged
from cross_checks.truths.truth import NoTruth
from mbs_ref import Scene, ephemeris
from mbs_ref.files import package_data
from mbs_ref.scenes.solar_system import julian_date

REFERENCE = "de440"
VERSIONS = {  # name: adapter
    "astropy_de440": "astropy_", "de421": "jplephem_", "de405": "jplephem_", "astropy_builtin": "astropy_",
}  # fmt: skip


class EphemerisMissing(ImportError):
    """Neither the ephemeris nor an excerpt for the date is at hand."""


def heliocentric(version: str, body: str, jd: float) -> np.ndarray | None:
    """Return the place (3,), m, of a planet relative to the Sun, or of the Moon relative to the Earth.

    None where the ephemeris does not contain the body.

    ValueError lists the versions; EphemerisMissing says what to install.
    """
    center = "earth" if body == "moon" else "sun"
    if version == REFERENCE:
        return ephemeris.state(body, jd)[0] - ephemeris.state(center, jd)[0]
    if version not in VERSIONS:
        raise ValueError(f"version = {version!r} is unknown; allowed: {', '.join([REFERENCE, *VERSIONS])}")
    try:
        adapter = importlib.import_module(f"{__name__}.{VERSIONS[version]}")
        return adapter.place(version, body, jd) - adapter.place(version, center, jd)
    except ModuleNotFoundError as missing:
        return _from_excerpt(version, body, jd, missing)
    except KeyError:
        return None


def _from_excerpt(version: str, body: str, jd: float, missing: ModuleNotFoundError) -> np.ndarray | None:
    dates = excerpt()["places_km"].get(version, {})
    if str(jd) not in dates:
        raise EphemerisMissing(
            f"{version} needs {missing.name}: pip install 'mbs-ref[ephemeris,engines]'; "
            f"the committed excerpt holds {', '.join(dates) or 'nothing of it'}"
        ) from missing
    row = dates[str(jd)].get(body)
    return None if row is None else np.array(row) * ephemeris.KM


@cache
def excerpt() -> dict[str, Any]:
    """Return the committed excerpt with its source."""
    return package_data(__name__, "spread_1998.json")


def spread(version: str, jd: float) -> dict[str, float]:
    """Return how far each body is from its place in DE440 (m): planets from the Sun, the Moon from the Earth."""
    gaps = {}
    for body in ephemeris.BODIES:
        if body == "sun":
            continue
        place, reference = heliocentric(version, body, jd), heliocentric(REFERENCE, body, jd)
        if place is not None and reference is not None:
            gaps[body] = float(np.linalg.norm(place - reference))
    return gaps


def figures(version: str, jd: float) -> dict[str, float]:
    """Return the significant figures to which a version agrees with DE440, body by body."""
    sizes = {body: np.linalg.norm(np.asarray(heliocentric(REFERENCE, body, jd))) for body in ephemeris.BODIES[1:]}
    return {body: float(-np.log10(gap / sizes[body])) for body, gap in spread(version, jd).items() if gap > 0.0}


OBSERVED_SCENES = ("solar_system",)


@dataclass(frozen=True)
class Observed:
    """Barycentric places at one time; NaN where a body is part of the model but not observed."""

    position: np.ndarray  # (n_bodies, 3) m
    how: str


def observe(scene: Scene, t: float) -> Observed | NoTruth | None:
    """Return the places at t (s), or why there are none; None for scenes that never were.

    Asteroids are not judged, and where Earth and Moon are lumped their barycentre is read as the Earth.
    """
    if scene.name not in OBSERVED_SCENES or not is_unchanged(scene):
        return None
    position = np.full((len(scene.bodies), 3), np.nan)
    try:
        for k, name in enumerate(scene.body_names):
            if name in ephemeris.BODIES:
                position[k] = ephemeris.positions(name, julian_date(str(scene.parameters["start"])), np.array([t]))[0]
    except ephemeris.EphemerisError as error:
        return NoTruth(str(error))
    return Observed(position, f"{ephemeris.describe()}, planets seen from the Sun, the Moon from the Earth")
