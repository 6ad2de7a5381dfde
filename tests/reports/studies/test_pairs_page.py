"""Pairs at equal error: rows of both sides, refusals with their reasons, places by Astropy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cross_checks import engines
from cross_checks.judge.cell import judged, tasks
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import OURS, Cell, TargetResult, Verdict
from cross_checks.records.record import Error, Record
from cross_checks.records.store import Store
from mbs_ref import scenes
from reports.facts import report_data as facts
from reports.facts.report_data import Entry
from reports.page.render import render
from reports.studies import pairs as measure
from reports.studies.pairs import Request, Result, pair, shown, sky_places
from tests.reports.page.synthetic_report import report_data

FEW = 1e-3
FIGURES = {"earth": 7.0, "jupiter": 4.0, "moon": 4.5}  # that a built-in ephemeris of four figures shares with our run


@pytest.fixture
def offered(monkeypatch):
    """Let our solver offer three methods."""
    ours = [(OURS, engines.get(OURS).method(name)) for name in ("euler", "dop853", "rk4")]
    monkeypatch.setattr(measure, "tasks", lambda names: [*ours, *tasks(names[1:])])


def test_every_method_enters_and_the_cheapest_one_is_shown(tmp_path: Path, monkeypatch, offered):
    monkeypatch.setattr(facts, "NEAR", float("inf"))  # every run is timed again
    monkeypatch.setattr(measure, "_loop", lambda scene, run: 1e-6 * run.rhs_calls)
    request = Request("A pendulum", "", (("pendulum", {}),), (), (FEW, 1e-11))
    with Store(tmp_path / "runs.sqlite") as store:
        runs = Runs(store)
        (scene,) = request.built()
        truth = runs.truth(scene)
        cells = [judged(runs, scene, *who, truth, request.targets)[0] for who in request.entrants()]
        rows = pair(runs, request)
    assert [row.target for row in rows] == [FEW, 1e-11]
    for row in rows:
        results = [result for cell in cells for result in cell.targets if result.target == row.target and result.record]
        best = min((result.record for result in results), key=lambda record: record.rhs_calls)
        assert (row.entry.method, row.entry.best.settings) == (best.method, best.settings)
        assert row.entry.best.times["loop_s"] == 1e-6 * best.rhs_calls
        assert row.ratio == 1.0
    assert rows[1].entry.method == "dop853"  # of three methods one reaches it


def test_no_run_is_made_that_cannot_be_the_cheapest(monkeypatch, offered):
    limits: dict[str, float] = {}
    loops = {"dop853": 0.3, "rk4": 0.2, "euler": 0.1}

    def judged(runs, scene, engine, method, *given, settle):
        limits[method.name] = runs.longest
        run = Record(scene.name, {}, engine, method.name, {}, "success", times={"loop_s": loops[method.name]})
        answers = [TargetResult(FEW, "reached", run), TargetResult(1e-11, "reached", run if method.order > 4 else None)]
        return Cell(scene.name, {}, engine, method.name, Verdict.AGREES, "", targets=tuple(answers)), ()

    monkeypatch.setattr(measure, "judged", judged)
    request = Request("A pendulum", "", (("pendulum", {}),), (), (FEW, 1e-11))
    measure._cells(Runs(longest=5.0), request.built()[0], OURS, request)
    near = facts.NEAR * 0.3
    assert limits == {"dop853": 5.0, "rk4": near, "euler": near}  # rk4 was the cheapest at one alone


def test_a_long_run_that_was_searched_on_a_busy_machine_has_its_quiet_time(monkeypatch):
    run = Record("pendulum", {}, OURS, "rk4", {}, "success", times={"loop_s": 3.0})
    quiet = replace(run, times={"loop_s": 1.2, "loop_runs": 3.0})
    monkeypatch.setattr(measure, "reaching", lambda *given: [run])
    monkeypatch.setattr(measure, "stored_times", lambda *given: quiet)
    (timed,) = measure._timed(Store(), scenes.make("pendulum"), report_data(), (FEW,))
    assert timed.times["loop_s"] == 1.2


def test_an_engine_that_cannot_run_the_scene_gives_its_reason(tmp_path: Path, offered):
    pytest.importorskip("exudyn")
    request = Request("Friction", "", (("incline", {}),), ("exudyn",), (FEW,))
    with Store(tmp_path / "runs.sqlite") as store:
        *_, last = pair(Runs(store), request)
    assert (last.entry.engine, last.target, last.entry.answer) == ("exudyn", None, "cannot")
    assert last.entry.reason


def test_searches_made_side_by_side_leave_nothing_to_run(tmp_path: Path, monkeypatch, offered):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "runs.sqlite"))
    request = Request("A pendulum", "", (("pendulum", {}),), (), (FEW,))
    monkeypatch.setattr(measure, "PAIRS", (request,))
    assert measure.parts() == [(0, 0, OURS)]
    measure.make((0, 0, OURS))
    with Store(tmp_path / "runs.sqlite") as store:
        runs = Runs(store)
        assert [row.entry.answer for row in pair(runs, request)] == ["reached"]
        assert runs.computed == 0


def test_our_planets_and_moon_are_where_astropy_says():
    pytest.importorskip("astropy")
    planets, *_, moons = sky_places().values()
    shared = {row["body"]: float(str(row["figures"])) for row in planets}
    assert all(shared[name] > least for name, least in FIGURES.items())
    apart = {row["body"]: str(row["apart"]).split() for row in moons}
    assert {unit for _, unit in apart.values()} == {"rad"}
    assert float(apart["sun"][0]) < 1e-4
    assert float(apart["moon"][0]) < 1e-3


def test_the_page_tells_rows_refusals_and_places():
    run = Record("chain", {}, OURS, "dop853", {"rtol": 1e-7}, "success", error=Error(3.1e-7, "exact", 1e-12, 0.0),
                 times={"loop_s": 2.3e-3})  # fmt: skip
    good = Result("chain", 1e-6, Entry(OURS, "reached", run, method="dop853"), False, 1.37)
    never = Result("chain", None, Entry("exudyn", "cannot", None, "closes a loop"))
    places = {"places: planets, day 200": ({"body": "mars", "apart": "4e6 m", "figures": 4.8},)}
    facts = shown([("Chains", "note", (good, never))], places)
    page = render(replace(report_data(), studies={"pairs": facts}))["pairs.html"].decode()
    assert "no rows to comply with" in page
    assert "cannot: closes a loop" in page
    assert "worked on" in page
    assert 'colspan="6"' in page
    assert "<td>★ 2.3 ms, dop853</td>" in page
    assert all(text in page for text in ("rtol = 1e-7", "3.1e-7", "2.3 ms", "1.37", "4.8"))


def test_the_cheapest_at_each_target_is_marked_and_plots_have_a_line_for_each_engine():
    def row(engine: str, target: float, seconds: float) -> Result:
        run = Record("chain", {}, engine, "rk4", {}, "success", error=Error(target, "exact", 0.0, 0.0),
                     times={"loop_s": seconds})  # fmt: skip
        return Result("chain", target, Entry(engine, "reached", run, method="rk4"))

    rows = [row(OURS, 1e-3, 1.0), row("exudyn", 1e-3, 2.0), row("exudyn", 1e-6, 3.0), row(OURS, 1e-6, 4.0)]
    facts = shown([("Chains", "", rows)], {})
    ours, theirs = facts.tables["beside: Chains"]
    assert [ours[key] for key in ("within 1e-3", "within 1e-6")] == ["★ 1 s, rk4", "4 s, rk4"]
    assert [theirs[key] for key in ("within 1e-3", "within 1e-6")] == ["2 s, rk4", "★ 3 s, rk4"]
    assert facts.curves[f"pair: Chains: chain ★ {OURS}, exudyn"].lines == {OURS: (1.0, 4.0), "exudyn": (2.0, 3.0)}
