"""The sky: which physics buys which digit, the paper's formulation beside ours, other ephemerides, races."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from cross_checks.records.numbers import duration, metres
from cross_checks.records.record import Record
from reports.drawing.plots.orbits import inner_orbits, outer_orbits
from reports.drawing.plots.sky_ladder import sky_ladder
from reports.facts.report_data import Finding, ReportData, Section
from reports.studies.sky.facts import Race, SkyFacts

LEAD = (
    "Significant figures of each body's place after 360 days against JPL DE440: planets seen from the Sun, the Moon "
    "from the Earth. Each row adds physics to the one before; an integrator that keeps the energy can still lose "
    "the Moon."
)
NAMES = {
    "lumped": "Newton, Earth and Moon as one", "newton": "Newton", "gr_sun": "+ relativity of the Sun alone",
    "gr": "+ relativity (EIH)", "j2": "+ J2 of Sun and Earth", "asteroids": "+ 16 asteroids",
    "full": "+ Moon's figure and tide, Kuiper ring",
}  # fmt: skip
WORTH_TELLING = 0.3  # figures, a factor of two in distance
EPHEMERIDES = {"de421": "DE421 (2008)", "de405": "DE405 (1997)", "astropy_builtin": "astropy's builtin series"}


def context(data: ReportData) -> dict[str, Any]:
    sky = data.study(SkyFacts)
    if sky is None:
        return {"sky": None}
    judged = [record for record in sky.ladder if record.figures]
    bodies = list(dict.fromkeys(name for record in judged for name in record.figures))
    spread = [(EPHEMERIDES[name], _cells(figures, bodies)) for name, figures in sky.spread.items()]
    return {
        "sky": sky,
        "bodies": bodies,
        "rows": [(NAMES[level_of(r)], f"{worst_planet(r):.2f}", _cells(r.figures, bodies)) for r in judged],
        "spread": spread,
        "formulations": [_formulation(record) for record in sky.formulations],
        "races": [_race(race) for race in sky.races],
        "plots": _plots(sky, judged),
    }


def level_of(record: Record) -> str:
    """Return the level of physics a record was run with."""
    return str(record.parameters["model"])


def worst_planet(record: Record) -> float:
    """Return the fewest figures of any planet."""
    return min(value for name, value in record.figures.items() if name != "moon")


def _plots(sky: SkyFacts, judged: list[Record]) -> dict[str, Any]:
    ladder = sky_ladder([NAMES[level_of(r)] for r in judged], [r.figures for r in judged])
    return {"Figures against physics": ladder, "A year of the inner planets": inner_orbits(sky.year),
            "The same year of the outer planets": outer_orbits(sky.year)}  # fmt: skip


def _cells(figures: dict[str, float], bodies: list[str]) -> list[str]:
    return [f"{figures[name]:.2f}" if name in figures else "not in it" for name in bodies]


def _formulation(record: Record) -> list[str]:
    rigid = record.parameters["formulation"] == "euler_parameters"
    name = "rigid bodies, Euler parameters" if rigid else "point masses"
    numbers = len(record.final) * (13 if rigid else 6)
    compliance = record.measure("compliance_position")
    return [
        f"{record.parameters['days']:g}",
        name + (", turning" if record.parameters["spin"] else ""),
        f"{worst_planet(record):.2f}",
        f"{record.figures['moon']:.2f}",
        f"{compliance:.1e}" if rigid and compliance is not None else "no constraint",
        str(numbers),
        str(record.steps),
        duration(record.times["loop_s"]),
    ]


def _race(race: Race) -> dict[str, Any]:
    laps = [[lap.scene, f"{lap.ratio:.1f}", _distance(lap.apart)] for lap in race.laps]
    told = f"{race.rival} takes {race.ratio:.2g} times as long as {race.ours} (95 %: {race.low:.2g} to {race.high:.2g})"
    return {"sentence": told, "laps": laps}


def _distance(apart: float | None) -> str:
    return "one did not get there" if apart is None else metres(apart)


def digits(data: ReportData) -> Iterator[Finding]:
    """Which physics buys which figures of the planets, and of the Moon."""
    sky = data.study(SkyFacts)
    ladder = [] if sky is None else [r for r in sky.ladder if r.figures and r.parameters["model"] != "gr_sun"]
    gains = []
    for before, after in pairwise(ladder):
        for name, figures in (("the worst planet", worst_planet), ("the Moon", _moon)):
            old, new = figures(before), figures(after)
            if old is not None and new is not None and new - old > WORTH_TELLING:
                gains.append(f"{after.parameters['model']} takes {name} from {old:.1f} to {new:.1f}")
    if gains:
        first, last = worst_planet(ladder[0]), worst_planet(ladder[-1])
        title = f"Physics buys digits: from {first:.1f} to {last:.1f} figures of every planet after 360 days"
        yield Finding("plain", title, "; ".join(gains) + ".")


def _moon(record: Record) -> float | None:
    return record.figures.get("moon")


SECTION = Section("sky", "The sky: which physics buys which digit", LEAD, context, digits)
