"""The androids' two sections, made from real but few runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbs_ref import scenes
from mbs_ref.crash.results import crash_results
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.page.render import render
from reports.studies.androids import measure as androids
from reports.studies.crashes.measure import Crash
from tests.reports.page.synthetic_report import report_data


def crash() -> Crash:
    scene = scenes.make(androids.SIMPLIFIED, impact="rear")
    path = simulate(scene, Settings(samples=41))
    return Crash(scene, path, crash_results(scene, path))


def facts() -> androids.AndroidFacts:
    scene = scenes.make(androids.SIMPLIFIED)
    settings = Settings(method="rk4", step=1e-3, stabilization="none")
    kept = androids.run(scene, settings)
    refused = androids.run(scene, settings.model_copy(update={"step": 8e-3}))
    apart = {"head": np.array([0.0, 1e-12]), "hip": np.array([0.0, 2e-12])}
    close = androids.Convergence(
        scene.name, "front", np.array([0.0, 0.2]), apart, {"dop853": 1e-15, "radau": 1e-15}, 1e-10, 1e-12
    )
    return androids.AndroidFacts((kept, refused), (androids.stable(scene),), (close,), ())


def test_runs_stable_steps_and_convergence_are_told():
    page = render(replace(report_data(), crashes=(crash(),), androids=facts()))
    assert "android_simplified, rear" in page
    assert "is beyond what rk4 can bear" in page
    assert "energy less works" in page
    assert "kept to the end" in page
