"""The sky, measured: digits against physics, races against IAS15 and heyoka, what Euler parameters cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cross_checks import engines, ephemerides
from cross_checks.judge.one_run import evaluate
from cross_checks.prices.timing import interval
from cross_checks.records.record import Record
from cross_checks.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.observables import energy_balance
from mbs_ref.observables.distance import distances
from mbs_ref.scene import Scene
from mbs_ref.scenes.solar_system import julian_date
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory
from reports.studies.sky.facts import Lap, Race, SkyFacts, Splitting

LEVELS = ("lumped", "newton", "gr_sun", "gr", "j2", "asteroids", "full")
FINE = Settings(method="gauss", rtol=1e-16, samples=2, estimate="off")
COARSE_SPLITTING = Settings(method="whfast", step=86_400.0, samples=2)  # a day: the Moon is 27 steps a revolution
RIGID = Settings(method="dop853", rtol=1e-12, samples=2, estimate="off")
DAYS = (200.0, 360.0)  # the paper's
START = "1998-01-01"
DECADE = 3652.5  # days
DATES = ("1998-01-01", "2000-01-01", "2010-01-01", "2020-01-01")  # all in the committed excerpt
IAS15 = Settings(method="ias15", rtol=1e-9, samples=2, estimate="off")  # its default, machine precision
TAYLOR = Settings(method="taylor", rtol=1e-15, samples=2)
ORBITS = ("leo", "gps", "molniya")
ORBIT_DAYS = 3.0
PAIRS = 5  # interleaved runs of each on each scene, of which the fastest counts
OBSERVED = NoTruth("held against where the bodies really were")


def measure() -> SkyFacts:
    """Run everything; half a minute with compiled code at hand."""
    scene = scenes.make("solar_system", model="newton")
    year = engines.get("mbs_ref").run(scene, FINE.model_copy(update={"samples": 361}))
    return SkyFacts(digits_ladder(), formulations(), spread(), races(), splitting(), _places(scene, year))


def _places(scene: Scene, path: Trajectory) -> dict[str, tuple[tuple[float, float, float], ...]]:
    """Return every body's places (m), to what a drawing shows."""
    return {
        name: tuple(tuple(float(f"{x:.6g}") for x in place) for place in path.position[:, k])
        for k, name in enumerate(scene.body_names)
    }  # type: ignore[return-value]


def digits_ladder() -> tuple[Record, ...]:
    """Return the solar system over 360 days at each level of physics."""
    return tuple(_observed(scenes.make("solar_system", model=level), "mbs_ref", FINE) for level in LEVELS)


def splitting() -> Splitting:
    """Return what a year of WHFast keeps and what it loses."""
    scene = scenes.make("solar_system", model="newton")
    record = _observed(scene, "rebound", COARSE_SPLITTING)
    if record.status != "success":
        return Splitting(None, None)
    path = engines.get("rebound").run(scene, COARSE_SPLITTING)
    balance = energy_balance(scene, path)
    assert balance.drift is not None
    return Splitting(float(np.abs(balance.drift / balance.energy[0]).max()), record.figures["moon"])


def formulations() -> tuple[Record, ...]:
    """Return Newton's gravity among point masses, and among rigid bodies with Euler parameters, still or turning."""
    kinds = ({}, {"formulation": "euler_parameters"}, {"formulation": "euler_parameters", "spin": True})
    made = [scenes.make("solar_system", model="newton", days=days, **kind) for days in DAYS for kind in kinds]
    return tuple(_observed(scene, "mbs_ref", RIGID) for scene in made)


def _observed(scene: Scene, engine: str, settings: Settings) -> Record:
    """Run without the truth of the scene's own equations, which takes minutes to make and is not shown."""
    return evaluate(scene, engine, settings, truth=OBSERVED)


def spread() -> dict[str, dict[str, float]]:
    """Return the figures that other ephemerides share with DE440, after 360 days."""
    jd = julian_date(START) + DAYS[-1]
    return {version: ephemerides.figures(version, jd) for version in ("de421", "de405", "astropy_builtin")}


def races() -> tuple[Race, ...]:
    """Return the races against the rivals that are installed."""
    decades = [scenes.make("solar_system", model="newton", days=DECADE, start=date) for date in DATES]
    satellites = [scenes.make("satellite", orbit=orbit, days=ORBIT_DAYS) for orbit in ORBITS]
    entered = (("rebound", IAS15, decades), ("heyoka", TAYLOR, satellites))
    found = []
    for name, settings, made in entered:
        try:
            engines.get(name)
        except engines.EngineMissing:
            continue
        found.append(race(name, settings, made))
    return tuple(found)


def race(rival: str, theirs: Settings, made: Sequence[Scene]) -> Race:
    """Run both in randomly interleaved pairs on every scene."""
    random = np.random.default_rng(0)
    laps = tuple(_lap(rival, theirs, scene, random) for scene in made)
    low, high = interval(np.array([lap.ratio for lap in laps]), random)
    return Race(f"{rival} {theirs.method}", f"mbs_ref {FINE.method}", laps, low, high)


def _lap(rival: str, theirs: Settings, scene: Scene, random: np.random.Generator) -> Lap:
    entrants = ((engines.get("mbs_ref"), FINE), (engines.get(rival), theirs))
    paths = [engine.run(scene, settings) for engine, settings in entrants]  # warms up
    best = [np.inf, np.inf]
    for _ in range(PAIRS):
        for k in random.permutation(2):
            engine, settings = entrants[k]
            best[k] = min(best[k], engine.run(scene, settings).timing.loop_s)
    shown = scene.parameters.get("orbit", scene.parameters.get("start"))
    return Lap(f"{scene.name} {shown}", best[1] / best[0], _apart(scene, *paths))


def _apart(scene: Scene, one: Trajectory, other: Trajectory) -> float | None:
    """Return the largest distance (m) between the two at the end."""
    if not (one.ok and other.ok):
        return None
    return float(distances(scene, one, other)[-1, :, 0].max())
