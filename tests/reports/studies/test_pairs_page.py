"""Pairs at equal error: rows of both sides, refusals with their reasons, places by Astropy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store
from reports.page.render import render
from reports.studies.pairs import measure
from reports.studies.pairs.facts import Pair, PairsFacts, Places, Row
from reports.studies.pairs.measure import OURS, Asked, pair
from reports.studies.pairs.sky_places import sky_places
from tests.reports.page.synthetic_report import report_data

FEW = 1e-3
FIGURES = {"earth": 7.0, "jupiter": 4.0, "moon": 4.5}  # that a built-in ephemeris of four figures shares with our run


def test_both_sides_meet_one_target_and_who_cannot_says_why(tmp_path: Path):
    pytest.importorskip("exudyn")
    asked = Asked("Loops", "", (("slider_crank", {}),),
                  ((OURS, ("dop853",)), ("exudyn", ("tree_dopri5",))), (FEW,))  # fmt: skip
    with Store(tmp_path / "runs.sqlite") as store:
        ours, *others = pair(Runs(store), asked).rows
    assert ours.engine == OURS
    assert ours.answer == "reached"
    assert ours.error is not None
    assert ours.error < FEW
    assert ours.ratio == 1.0
    assert ours.compliance is not None
    answers = {row.engine: row for row in others}
    assert answers["exudyn"].answer == "cannot"
    assert "loop" in answers["exudyn"].reason


def test_searches_made_side_by_side_leave_nothing_to_run(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "runs.sqlite"))
    asked = Asked("A pendulum", "", (("pendulum", {}),), ((OURS, ("dop853", "rk4")),), (FEW,))
    monkeypatch.setattr(measure, "PAIRS", (asked,))
    assert measure.parts() == [(0, 0, 0), (0, 0, 1)]
    for part in reversed(measure.parts()):
        measure.make(part)
    with Store(tmp_path / "runs.sqlite") as store:
        runs = Runs(store)
        assert [row.answer for row in pair(runs, asked).rows] == ["reached", "reached"]
        assert runs.made == 0


def test_our_planets_and_moon_are_where_astropy_says():
    pytest.importorskip("astropy")
    planets, *_, moons = sky_places()
    assert all(planets.figures[name] > least for name, least in FIGURES.items())
    assert moons.unit == "rad"
    assert moons.apart["sun"] < 1e-4
    assert moons.apart["moon"] < 1e-3


def test_the_page_tells_rows_refusals_and_places():
    good = Row("chain", OURS, "dop853", 1e-6, "reached", "", "rtol = 1e-7", 3e-7, None, None, 2e-3, 1.0)
    never = Row("chain", "exudyn", "tree", None, "cannot", "closes a loop")
    facts = PairsFacts(
        (Pair("Chains", "note", (good, never)),), (Places("planets", 200.0, {"mars": 4e6}, "m", {"mars": 4.8}),)
    )
    page = render(replace(report_data(), studies={"pairs": facts}))["pairs.html"].decode()
    assert "no rows to comply with" in page
    assert "cannot: closes a loop" in page
    assert "worked on" in page
    assert 'colspan="6"' in page
    assert "4.8" in page
