"""Where things in the sky are by our runs and by the ephemeris that Astropy brings along, without any download."""

import importlib

import numpy as np

from cross_checks.judge.ladder import grid
from cross_checks.records.numbers import metres, short
from mbs_ref import Settings, scenes
from mbs_ref.kernels.particles.directions import moon_place, sun_place
from mbs_ref.scenes.solar_system import julian_date
from mbs_ref.simulate import simulate
from reports.facts.curves import Row

Tables = dict[str, tuple[Row, ...]]

BUILTIN = "astropy_builtin"
START = "1998-01-01"
DAYS = (200.0, 360.0)
J2000 = 2_451_545.0  # JD TDB
SATELLITE_DAYS = (0.0, 100.0, 200.0, 300.0)
FINE = Settings(method="gauss", rtol=1e-16, estimate="off")


def sky_places() -> Tables:
    """Return a table of bodies by title: how far apart, and the figures shared. None where astropy is not installed."""
    try:
        astropy = importlib.import_module("cross_checks.ephemerides.astropy_")
    except ModuleNotFoundError:
        return {}
    planets, moons = (_planets(astropy, days) for days in DAYS), (_sun_and_moon(astropy, d) for d in SATELLITE_DAYS)
    return {title: rows for tables in (*planets, *moons) for title, rows in tables.items()}


def _places(what: str, days: float, apart: dict[str, float], figures: dict[str, float], unit: str) -> Tables:
    """Return one table, of distances (m) or angles (rad)."""
    written = metres if unit == "m" else lambda value: f"{short(value)} {unit}"
    rows = ({"body": name, "apart": written(gap), "figures": figures[name]} for name, gap in apart.items())
    return {f"places: {what}, day {days:g}": tuple(rows)}


def _planets(astropy, days: float) -> Tables:
    """The planets as our run leaves them, from DE440's start, seen from the Sun; the Moon from the Earth."""
    scene = scenes.make("solar_system", days=days, start=START)
    path = simulate(scene, FINE, grid(scene)[[0, -1]])
    jd = julian_date(START) + days
    ours = {name: path.position[-1, k] for k, name in enumerate(scene.body_names)}
    apart, figures = {}, {}
    for name in ours:
        center = "earth" if name == "moon" else "sun"
        if name in ("sun", "pluto") or not _has(astropy, name, jd):
            continue
        theirs = astropy.place(BUILTIN, name, jd) - astropy.place(BUILTIN, center, jd)
        apart[name] = float(np.linalg.norm(ours[name] - ours[center] - theirs))
        figures[name] = float(-np.log10(apart[name] / np.linalg.norm(theirs)))
    return _places("planets of our run against Astropy's built-in ephemeris", days, apart, figures, "m")


def _has(astropy, name: str, jd: float) -> bool:
    try:
        astropy.place(BUILTIN, name, jd)
    except KeyError:
        return False
    return True


def _sun_and_moon(astropy, days: float) -> Tables:
    """The Sun's and the Moon's direction in the satellites' forces, from the Earth."""
    apart, figures = {}, {}
    for name, place in (("sun", sun_place), ("moon", moon_place)):
        ours = np.zeros(3)
        place(days, ours)
        theirs = astropy.place(BUILTIN, name, J2000 + days) - astropy.place(BUILTIN, "earth", J2000 + days)
        cosine = ours @ theirs / (np.linalg.norm(ours) * np.linalg.norm(theirs))
        apart[name] = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        figures[name] = float(-np.log10(np.linalg.norm(ours - theirs) / np.linalg.norm(theirs)))
    return _places("Sun and Moon of the satellites' forces against Astropy's", days, apart, figures, "rad")
