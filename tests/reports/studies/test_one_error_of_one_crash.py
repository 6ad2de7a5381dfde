"""Two studies that run the same crash by the same method show the same error of it."""

from __future__ import annotations

from mbs_ref import scenes
from mbs_ref.settings import Settings
from reports.studies.androids.measure import PAPER_STEP, PAPERS, run
from reports.studies.papers.crash_figures import _method


def test_both_studies_give_one_error_of_one_crash():
    scene = scenes.make("android_simplified")
    ours, _ = run(scene, Settings(method="euler", step=PAPER_STEP, events="none", **PAPERS))
    papers = _method("simplified", scene, "euler", {"step": PAPER_STEP})
    assert ours.error is not None
    assert papers["simplified.euler.error"] == ours.error
    assert 1e-6 < ours.error < 1e-1  # m
