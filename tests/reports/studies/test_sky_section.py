"""The sky's section: every figure said, plots that draw, findings told by one rule."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cross_checks.records.record import Record
from reports.facts.report_data import ReportData
from reports.studies.sky import section as sky
from reports.studies.sky.facts import Lap, Race, SkyFacts, Splitting

BODIES = ("sun", "mercury", "earth", "moon", "jupiter")


def record(model: str, planets: float, moon: float | None, **parameters) -> Record:
    figures = {"mercury": planets, "jupiter": planets + 1.0} | ({} if moon is None else {"moon": moon})
    told = {"model": model, "days": 360.0, "formulation": "point", "spin": False} | parameters
    return Record(
        scene="solar_system", parameters=told, engine="mbs_ref", method="gauss", settings={"rtol": 1e-16},
        status="success", message="", t_end=3e7, steps=99, rhs_calls=999, final={name: {} for name in BODIES},
        measures={"compliance_position": 7e-16}, error=None, times={"loop_s": 0.01}, versions={}, figures=figures,
    )  # fmt: skip


@pytest.fixture
def facts() -> SkyFacts:
    year = {name: ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)) for name in BODIES}
    ladder = (record("lumped", 4.5, None), record("newton", 5.4, 4.3), record("gr", 8.6, 4.2), record("j2", 8.7, 5.7))
    rigid = record("newton", 5.4, 4.3, formulation="euler_parameters", spin=True)
    laps = (Lap("solar_system 1998-01-01", 7.0, 0.1), Lap("solar_system 2000-01-01", 9.0, None))
    race = Race("rebound ias15", "mbs_ref gauss", laps, 7.0, 9.0)
    spread = {"de421": {"mercury": 8.4}, "de405": {}, "astropy_builtin": {"mercury": 5.5}}
    return SkyFacts(ladder, (ladder[1], rigid), spread, (race,), Splitting(1e-14, 1.7), year)


def test_the_section_says_every_figure(facts):
    found = sky.context(ReportData((), (), studies={"sky": facts}))
    assert [worst for _, worst, _ in found["rows"]] == ["4.50", "5.40", "8.60", "8.70"]
    assert found["rows"][0][2][found["bodies"].index("moon")] == "not in it"
    assert [row[1] for row in found["formulations"]] == ["point masses", "rigid bodies, Euler parameters, turning"]
    assert [row[5] for row in found["formulations"]] == ["30", "65"]
    assert found["races"][0]["sentence"].startswith("rebound ias15 takes 8 times as long")
    assert set(found["plots"]) == {
        "Figures against physics", "A year of the inner planets", "The same year of the outer planets",
    }  # fmt: skip


def test_findings_tell_which_physics_buys_which_digits(facts):
    (found,) = sky.SECTION.findings(ReportData((), (), studies={"sky": facts}))
    assert "gr takes the worst planet from 5.4 to 8.6" in found.text
    assert "j2 takes the Moon from 4.2 to 5.7" in found.text
    assert "j2 takes the worst planet" not in found.text
    assert not list(sky.SECTION.findings(ReportData((), ())))


def test_without_rebound_the_section_still_stands(facts):
    bare = replace(facts, races=(), splitting=Splitting(None, None))
    from reports.page.render import render

    page = render(ReportData((), (), studies={"sky": bare}))["sky.html"].decode()
    assert "WHFast at one day" not in page
    assert "Figures against physics" in page
