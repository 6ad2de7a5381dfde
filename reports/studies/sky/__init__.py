"""The sky, measured: digits against physics, what Euler parameters cost."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from cross_checks import engines, ephemerides
from cross_checks.judge.one_run import evaluate
from cross_checks.records.record import Record
from cross_checks.truths.truth import NoTruth
from mbs_ref import Scene, Settings, scenes
from mbs_ref.observables import energy_balance
from mbs_ref.scene.celestial import AU_M
from mbs_ref.scenes.solar_system import julian_date
from reports.facts.curves import Curves, Measured, Row, plain
from reports.studies.sky.frames import by_sgp4, comparisons

LEVELS = {
    "lumped": "Newton, Earth and Moon as one", "newton": "Newton", "gr_sun": "+ relativity of the Sun alone",
    "gr": "+ relativity (EIH)", "j2": "+ J2 of Sun and Earth", "asteroids": "+ 16 asteroids",
    "full": "+ Moon's figure and tide, Kuiper ring",
}  # fmt: skip
EPHEMERIDES = {"de421": "DE421 (2008)", "de405": "DE405 (1997)", "astropy_builtin": "astropy's builtin series"}
FINE = Settings(method="gauss", rtol=1e-16, samples=2, estimate="off")
COARSE_SPLITTING = Settings(method="whfast", step=86_400.0, samples=2)  # a day: the Moon is 27 steps a revolution
RIGID = Settings(method="dop853", rtol=1e-12, samples=2, estimate="off")
DAYS = (200.0, 360.0)  # the paper's
START = "1998-01-01"
OBSERVED = NoTruth("compared with where the bodies really were")
GAIN = 0.3  # significant figures, a factor of two in distance: a smaller gain is not stated
OBLIQUITY = np.radians(84_381.406 / 3600.0)  # of the ecliptic of J2000, IAU 2006
INNER = ("mercury", "venus", "earth", "mars")
HIDDEN = ("sun", "moon")  # the Sun is the origin; the Moon would hide behind the Earth


def measure() -> Measured:
    """Run everything; half a minute with compiled code at hand."""
    measured = Measured()
    add_levels(measured, [observed(scenes.make("solar_system", model=level), "mbs_ref", FINE) for level in LEVELS])
    add_formulations(measured, formulations())
    measured.tables["figures: Other ephemerides at the same time"] = tuple(
        {"name": EPHEMERIDES[name]} | figures for name, figures in spread().items()
    )
    measured.tables["frames"], measured.tables["sgp4"] = comparisons(), by_sgp4()
    add_splitting(measured)
    scene = scenes.make("solar_system", model="newton")
    year = engines.get("mbs_ref").run(scene, FINE.model_copy(update={"samples": 361}))
    add_orbits(measured, {name: year.position[:, k] for k, name in enumerate(scene.body_names)})
    return measured


def add_levels(measured: Measured, records: Sequence[Record]) -> None:
    """Add the significant figures of the solar system over 360 days at each level of physics."""
    judged = [record for record in records if record.figures]
    names = [LEVELS[str(record.parameters["model"])] for record in judged]
    rows = ({"name": n, "worst": worst_planet(r)} | r.figures for n, r in zip(names, judged, strict=True))
    measured.tables["figures: Physics in the model"] = tuple(rows)
    bodies = dict.fromkeys(body for record in judged for body in record.figures)
    lines = {body: tuple(record.figures.get(body) for record in judged) for body in bodies}
    labels = "significant figures", "physics in the model"
    measured.curves["Figures against physics"] = Curves(tuple(names), lines, *labels, marks="lines+markers")
    steps = [record for record in judged if record.parameters["model"] != "gr_sun"]  # each contains the one before
    gains = [gain for before, after in pairwise(steps) for gain in _gains(before, after)]
    if gains:
        first, last = worst_planet(judged[0]), worst_planet(judged[-1])
        measured.figures.update({"levels.gains": "; ".join(gains), "levels.first": first, "levels.last": last})


def worst_planet(record: Record) -> float:
    """Return the fewest figures of any planet."""
    return min(value for name, value in record.figures.items() if name != "moon")


def _gains(before: Record, after: Record) -> list[str]:
    """Return which figures a level of physics improves."""
    pairs = {"the worst planet": (worst_planet(before), worst_planet(after))}
    if "moon" in before.figures and "moon" in after.figures:
        pairs["the Moon"] = before.figures["moon"], after.figures["moon"]
    model = after.parameters["model"]
    return [
        f"{model} takes {name} from {old:.1f} to {new:.1f}" for name, (old, new) in pairs.items() if new - old > GAIN
    ]


def add_splitting(measured: Measured) -> None:
    """Add the relative energy error of a year of WHFast, and the Moon's figures; nothing without rebound."""
    scene = scenes.make("solar_system", model="newton")
    record = observed(scene, "rebound", COARSE_SPLITTING)
    if record.status != "success":
        return
    balance = energy_balance(scene, engines.get("rebound").run(scene, COARSE_SPLITTING))
    assert balance.drift is not None
    energy = float(np.abs(balance.drift / balance.energy[0]).max())
    measured.figures.update({"splitting.energy": energy, "splitting.moon": record.figures["moon"]})


def formulations() -> list[Record]:
    """Return Newton's gravity among point masses, and among rigid bodies with Euler parameters, still or turning."""
    kinds = ({}, {"formulation": "euler_parameters"}, {"formulation": "euler_parameters", "spin": True})
    built = [scenes.make("solar_system", model="newton", days=days, **kind) for days in DAYS for kind in kinds]
    return [observed(scene, "mbs_ref", RIGID) for scene in built]


def add_formulations(measured: Measured, records: Sequence[Record]) -> None:
    """Add a row for each formulation."""
    measured.tables["formulations"] = tuple(map(_formulation, records))


def _formulation(record: Record) -> Row:
    rigid = record.parameters["formulation"] == "euler_parameters"
    name = "rigid bodies, Euler parameters" if rigid else "point masses"
    return {
        "days": record.parameters["days"], "model": name + (", turning" if record.parameters["spin"] else ""),
        "worst": worst_planet(record), "moon": record.figures["moon"],
        "norm": record.measure("compliance_position") if rigid else None,
        "numbers": len(record.final) * (13 if rigid else 6), "steps": record.steps, "loop_s": record.times["loop_s"],
    }  # fmt: skip


def observed(scene: Scene, engine: str, settings: Settings) -> Record:
    """Run and compare with an ephemeris; the truth of the scene's own equations takes minutes and is not shown."""
    return evaluate(scene, engine, settings, truth=OBSERVED)


def spread() -> dict[str, dict[str, float]]:
    """Return the figures that other ephemerides share with DE440, after 360 days."""
    jd = julian_date(START) + DAYS[-1]
    return {version: ephemerides.figures(version, jd) for version in EPHEMERIDES}


def add_orbits(measured: Measured, year: Mapping[str, np.ndarray]) -> None:
    """Add the planets' paths in the ecliptic about the Sun, from barycentric places (n_t, 3), m, equatorial axes."""
    labels = "y, au", "x, au"
    for name, places in year.items():
        seen = (np.asarray(places) - year["sun"]) / AU_M
        y = np.cos(OBLIQUITY) * seen[:, 1] + np.sin(OBLIQUITY) * seen[:, 2]
        if name not in HIDDEN:
            group = "inner" if name in INNER else "outer"
            path = Curves(plain(seen[:, 0].round(4)), {name: plain(y.round(4))}, *labels, equal=True)
            measured.curves[f"{group} planets: {name}"] = path
    for group in ("inner", "outer"):
        measured.curves[f"{group} planets: sun"] = Curves((0.0,), {"sun": (0.0,)}, *labels, marks="markers", equal=True)
