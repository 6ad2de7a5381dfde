"""The androids' two sections, made from real but few runs."""

from __future__ import annotations

from dataclasses import replace

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.facts.curves import Measured, curves
from reports.facts.report_data import ReportData
from reports.facts.stored import adapter
from reports.page.build import data_of
from reports.page.render import render
from reports.studies import androids, crash
from reports.studies.crash import PAPER, SIMPLIFIED
from reports.studies.crashes import add_crash
from tests.reports.page.synthetic_report import report_data


def occupant() -> Measured:
    measured, scene = Measured(), scenes.make(SIMPLIFIED, impact="rear", **PAPER)
    add_crash(measured, scene, simulate(scene, Settings(samples=41, estimate="off")))
    return measured


def methods() -> Measured:
    measured, scene = Measured(), scenes.make(SIMPLIFIED, **PAPER)
    measured.tables["androids"] = ({"android": androids.label(scene)},)
    settings = Settings(method="rk4", step=1e-3, stabilization="none")
    androids.add_run(measured, scene, settings)
    androids.add_run(measured, scene, settings.model_copy(update={"step": 8e-3}))
    androids.add_stable(measured, scene)
    return measured


def page_of(**studies: Measured) -> str:
    return render(replace(report_data(), studies=studies))["androids.html"].decode()


def test_runs_and_stable_steps_are_shown_from_facts_that_json_preserves(monkeypatch):
    monkeypatch.setattr(crash, "off_truth", lambda scene, path: None)  # its truth takes seconds
    data = replace(report_data(), studies={"crashes": occupant(), "androids": methods()})
    read = data_of(adapter(ReportData).dump_json(data))
    assert read == data
    files = render(read)
    page = files["androids.html"].decode()
    assert "android_simplified, rear" in page
    assert "is beyond what rk4 can bear" in page
    assert "energy less works" in page
    assert "kept to the end" in page
    assert any(name.startswith("crashes-android_simplified-rear") and name.endswith(".gif") for name in files)


def test_the_papers_front_crash_is_shown_with_its_own_figures(monkeypatch):
    """Runs of the rear crash come later and must not take its place."""
    monkeypatch.setattr(crash, "off_truth", lambda scene, path: None)  # its truth takes seconds
    figures = {"androids.rk4.compliance": 1.25e-12, "androids.euler.compliance": 4.5e-4}
    page = page_of(androids=Measured(figures))
    assert "1.2e-12 m" in page
    assert "4.5e-4 m" in page
    assert "These data do not reproduce that" not in page_of(androids=Measured({"androids.rk4.compliance": 1e-3}))
    rear = scenes.make(SIMPLIFIED, impact="rear", **PAPER)
    measured = Measured()
    androids.add_run(measured, rear, Settings(method="euler", step=1e-3, stabilization="none", events="none"))
    assert not measured.figures


def test_lines_of_one_overlay_are_named_by_what_the_star_stands_for():
    line = curves([0.0, 0.1], {"head": [1e-12, 2e-12], "hip": [1e-12, 3e-12]}, "distance, m", log=True)
    page = page_of(androids=Measured(curves={"gaps: android_simplified, front": line}))
    assert "android_simplified, front: hip" in page
