"""The sky's page: every figure is shown, plots have their lines, and one rule states what physics improves."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cross_checks.records.record import Record
from reports.facts.curves import Measured
from reports.facts.report_data import ReportData
from reports.page.render import render
from reports.studies import sky
from reports.studies.sky.frames import comparisons

BODIES = ("sun", "mercury", "earth", "moon", "jupiter")


def record(model: str, planets: float, moon: float | None, **parameters) -> Record:
    figures = {"mercury": planets, "jupiter": planets + 1.0} | ({} if moon is None else {"moon": moon})
    given = {"model": model, "days": 360.0, "formulation": "point", "spin": False} | parameters
    return Record(
        scene="solar_system", parameters=given, engine="mbs_ref", method="gauss", settings={"rtol": 1e-16},
        status="success", message="", t_end=3e7, steps=99, rhs_calls=999, final={name: {} for name in BODIES},
        measures={"compliance_position": 7e-16}, error=None, times={"loop_s": 0.01}, versions={}, figures=figures,
    )  # fmt: skip


@pytest.fixture
def facts() -> Measured:
    measured = Measured()
    levels = record("lumped", 4.5, None), record("newton", 5.4, 4.3), record("gr", 8.6, 4.2), record("j2", 8.7, 5.7)
    sky.add_levels(measured, levels)
    rigid = record("newton", 5.4, 4.3, formulation="euler_parameters", spin=True)
    sky.add_formulations(measured, (levels[1], rigid))
    sky.add_orbits(measured, {name: np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]) for name in BODIES})
    return measured


def data(facts: Measured) -> ReportData:
    return ReportData((), (), studies={"sky": facts})


def page(facts: Measured) -> str:
    return render(data(facts))["sky.html"].decode()


def test_the_page_shows_every_figure(facts):
    shown = page(facts)
    rows = [re.findall(r"<td>(.*?)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", shown)]
    levels = {row[0]: row for row in rows if row and row[0] in sky.LEVELS.values()}
    assert [row[1] for row in levels.values()] == ["4.50", "5.40", "8.60", "8.70"]
    assert levels["Newton, Earth and Moon as one"][5] == "not in it"
    formulations = [row for row in rows if row and row[0] == "360"]
    assert [row[1] for row in formulations] == ["point masses", "rigid bodies, Euler parameters, turning"]
    assert [(row[4], row[5]) for row in formulations] == [("no constraint", "30"), ("7.0e-16", "65")]
    for title in ("Figures against physics", "A year of the inner planets", "The same year of the outer planets"):
        assert title in shown


def test_plots_have_a_line_for_each_body_and_gaps_where_it_is_unknown(facts):
    levels = facts.curves["Figures against physics"]
    assert levels.lines["moon"] == (None, 4.3, 4.2, 5.7)
    assert {name for name in facts.curves if name.startswith("inner")} == {
        "inner planets: sun", "inner planets: mercury", "inner planets: earth",
    }  # fmt: skip


def test_the_page_states_which_physics_improves_which_figures(facts):
    shown = page(facts)
    assert "gr takes the worst planet from 5.4 to 8.6" in shown
    assert "j2 takes the Moon from 4.2 to 5.7" in shown
    assert "j2 takes the worst planet" not in shown


def test_a_lost_moon_is_stated_and_the_page_does_without_rebound(facts):
    assert "WHFast at one day" not in page(facts)
    facts.figures.update({"splitting.energy": 1e-14, "splitting.moon": 0.4})
    assert "has lost the\nMoon" in page(facts)
    facts.figures["splitting.moon"] = 1.7
    assert "place to 1.7 figures" in page(facts)


def test_each_part_of_the_earths_rotation_brings_the_track_closer_to_astropys():
    """Precession, nutation and UT1 in turn; metres remain, as polar motion is left out. Aberration is 20 arcseconds."""
    pytest.importorskip("astropy")
    rows = {str(row["name"]): row for row in comparisons()}
    tracks = [float(row["apart"] or 0.0) for name, row in rows.items() if "ITRS" in name]
    assert sorted(tracks, reverse=True) == tracks
    assert tracks[-1] < 15.0  # m: polar motion of half an arcsecond
    assert float(rows["the same satellite in TEME, SGP4's frame"]["apart"] or 0.0) < 5.0  # m
    assert float(rows["Mars from the Earth: and aberration"]["figures"] or 0.0) > 7.0
    assert float(rows["TDB - UTC"]["apart"] or 0.0) < 1e-4  # s
