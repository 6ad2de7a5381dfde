"""The first screen: engine by scene, the cost of accuracy over all scenes, and what went wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import Cell, Verdict
from cross_checks.records.record import Error, Record
from reports.facts.report_data import ReportData
from reports.page.build import publish
from reports.page.findings import findings
from reports.page.render import pages
from reports.page.sections.overview import context, frontier_plot
from tests.reports.page.synthetic_report import report_data
from tests.reports.page.test_shown_figures import irregular

# engine -> scene -> (seconds, error) of its runs
RUNS = {
    "mujoco": {"pendulum": [(1.0, 1e-2), (4.0, 1e-6)], "double_pendulum": [(2.0, 1e-6)]},
    "exudyn": {"pendulum": [(8.0, 1e-7)], "double_pendulum": []},
}  # fmt: skip


def record(engine: str, scene: str, seconds: float, error: float) -> Record:
    return Record(
        scene=scene, parameters={}, engine=engine, method="m", settings={"step": seconds}, status="success", message="",
        t_end=1.0, steps=1, rhs_calls=1, final={}, measures={}, error=Error(error, "exact", 0.0, error, length=1.0),
        times={"build_s": 0.0, "first_call_s": 0.0, "loop_s": seconds}, versions={}, history={},
    )  # fmt: skip


@pytest.fixture
def data() -> ReportData:
    records, cells = [], []
    for engine, scenes in RUNS.items():
        for scene, own in scenes.items():
            made = [record(engine, scene, *run) for run in own]
            reached = [r for r in made if r.error.value <= 1e-6]
            targets = report_data().cells[0].targets[1:2] if reached else ()
            targets = tuple(replace(target, record=reached[0]) for target in targets)
            cells.append(Cell(scene, {}, engine, "m", Verdict.AGREES, "", targets=targets))
            records += made
    return ReportData(tuple(cells), tuple(records))


def test_costs_are_medians_over_the_scenes_that_an_engine_models(data):
    lines = {trace["meta"]["engine"]: dict(zip(trace["y"], trace["x"], strict=True))
             for trace in frontier_plot(data)["data"]}  # fmt: skip
    # of the cheapest within 1e-6, 4 s and 2 s: (1/4, 2/2) at 1e-2, (4/4, 2/2) at 1e-6
    assert lines["mujoco"][1e-2] == pytest.approx(0.625)
    assert lines["mujoco"][1e-6] == pytest.approx(1.0)
    assert min(lines["mujoco"]) == 1e-6
    assert "exudyn" not in lines or not lines["exudyn"], "half of its scenes are missed at every error"


def test_no_line_goes_beyond_the_smallest_error_that_engines_were_to_reach(data):
    """What a dearer method reaches there by chance is not an engine's cost."""
    finest = min(TARGETS)
    beyond = [record("mujoco", scene, 100.0, 1e-3 * finest) for scene in ("pendulum", "double_pendulum")]
    lines = frontier_plot(replace(data, records=(*data.records, *beyond)))["data"]
    assert {trace["meta"]["engine"]: min(trace["y"]) for trace in lines if trace["y"]} == {
        "mujoco": pytest.approx(finest)
    }


def test_a_cell_shows_the_smallest_error_and_the_cost_at_1e_6(data):
    rows = {
        row["scene"]: dict(zip(context(data)["engines"], row["cells"], strict=True)) for row in context(data)["rows"]
    }
    cell = rows["pendulum"]["mujoco"]
    assert (cell["error"], cell["time"], cell["share"], cell["wrong"]) == ("1e-6", "4 s", 40, "")
    assert not rows["double_pendulum"]["exudyn"]["error"]


def test_a_scene_on_which_a_method_is_silently_wrong_is_marked():
    shown = {
        (row["scene"], engine)
        for row in context(report_data())["rows"]
        for engine, cell in zip(context(report_data())["engines"], row["cells"], strict=True)
        if cell.get("wrong")
    }
    silent = {(c.label, c.engine) for c in report_data().cells if c.verdict in ("wrong-limit", "lost", "diverged")}
    assert shown == silent


@pytest.mark.parametrize("seed", range(3))
def test_the_first_screen_names_the_six_worst_findings_and_counts_all(seed):
    """The page of findings holds all of them; the pages of scenes and engines hold none."""
    data = irregular(seed)
    listed, shown = findings(data), {}
    for page in pages(data):
        for section in page.sections:
            if "findings" in (given := section.context(page.data)):
                shown[page.file] = given["findings"], given["number"]
    assert len(listed) > 6
    assert shown == {"index.html": (listed[:6], len(listed)), "findings.html": (listed, len(listed))}


def test_findings_are_ranked_by_the_delivered_error_and_lead_to_their_scene_and_command(tmp_path: Path):
    listed = findings(report_data())
    errors = [finding.error for finding in listed]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] == max(c.error for c in report_data().cells if c.verdict in ("wrong-limit", "diverged"))
    assert {finding.tone for finding in listed} <= {"bad", "fair"}
    page = publish(report_data(), tmp_path).with_name("findings.html").read_text()
    for finding in listed:
        assert finding.scene in report_data().scenes
        assert f'data-command="{finding.command}"' in page.replace("&#39;", "'")
