"""The androids' two sections, made from real but few runs."""

from __future__ import annotations

from dataclasses import replace

from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.drawing.numbers import short
from reports.facts.curves import Curves
from reports.facts.kept import adapter
from reports.facts.report_data import ReportData
from reports.page.publish import data_of
from reports.page.render import render
from reports.studies.androids import measure as androids
from reports.studies.androids import section
from reports.studies.androids.facts import AndroidFacts, Convergence
from reports.studies.crashes.facts import CrashFacts
from reports.studies.crashes.measure import crash
from tests.reports.page.synthetic_report import report_data


def occupant() -> CrashFacts:
    scene = scenes.make(androids.SIMPLIFIED, impact="rear")
    return CrashFacts((crash(scene, simulate(scene, Settings(samples=41))),))


def facts() -> AndroidFacts:
    scene = scenes.make(androids.SIMPLIFIED)
    settings = Settings(method="rk4", step=1e-3, stabilization="none")
    kept, _ = androids.run(scene, settings)
    refused, _ = androids.run(scene, settings.model_copy(update={"step": 8e-3}))
    apart = Curves((0.2,), {"head": (1e-12,), "hip": (2e-12,)}, "distance, m", log=True)
    close = Convergence(scene.name, "front", apart, {"dop853": 1e-15, "radau": 1e-15}, 1e-10, 1e-12)
    return AndroidFacts((kept, refused), (androids.stable(scene),), (close,), ())


def test_runs_stable_steps_and_convergence_are_told_from_facts_that_json_keeps():
    data = replace(report_data(), studies={"crashes": occupant(), "androids": facts()})
    kept = data_of(adapter(ReportData).dump_json(data))
    assert kept == data
    files = render(kept)
    page = files["androids.html"].decode()
    assert "android_simplified, rear" in page
    assert "is beyond what rk4 can bear" in page
    assert "energy less works" in page
    assert "kept to the end" in page
    assert files["android_simplified-rear.gif"].startswith(b"GIF")


def test_the_papers_front_crash_is_told_with_its_own_figures():
    """Runs of the rear crash come later in the facts and must not take its place."""
    found = facts()
    front = replace(found.runs[0], compliance=1.25e-12)
    euler = replace(front, method="euler", compliance=4.5e-4)
    rear = [replace(run, impact="rear", compliance=9.9) for run in (front, euler)]
    told = replace(found, runs=(front, euler, *rear))
    said = section.context(replace(report_data(), studies={"androids": told}))["claim"]
    assert f"{short(front.compliance)} m" in said
    assert f"{short(euler.compliance)} m" in said
    assert "9.9" not in said
