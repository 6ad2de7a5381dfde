"""What the page says of the trade: performance profiles with their tables, and the truths behind every error."""

from __future__ import annotations

from dataclasses import replace

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.ladder import grid
from cross_checks.truths import seek_truth
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from reports.facts.report_data import ReportData
from reports.facts.scene_facts import TruthFacts, truth_facts
from reports.page.build import publish
from reports.page.sections.profiles import context
from tests.reports.page.synthetic_report import report_data

DATA = report_data()


def test_a_profile_at_each_accuracy_ranks_engines_and_leaves_ours_out():
    blocks = context(DATA)["blocks"]
    assert len(blocks) == len(TARGETS)
    for block in blocks:
        engines = [row["engine"] for row in block["rows"]]
        assert "mbs_ref" not in engines
        assert len(set(engines)) == len(engines) == len(block["plot"]["data"])
        for trace in block["plot"]["data"]:
            assert trace["y"] == sorted(trace["y"])
            assert trace["line"]["shape"] == "hv"
    best = blocks[1]["rows"][0]
    assert best["shares"][0] == max((row["shares"][0] for row in blocks[1]["rows"]), key=lambda text: int(text[:-1]))


def test_truths_are_certified_agreed_or_none(tmp_path):
    facts = (
        TruthFacts("pendulum", "", "exact", "by hand", 1e-14, 3e-13, None, 1.0, "2026-01-01", "somebody", 1e-12, 0.0),
        TruthFacts("new", "", "agreed", "two engines", 1e-9, 3e-8, None, 1.0),
        TruthFacts("none", none="it is chaotic"),
    )
    publish(ReportData((), (), truths=facts), tmp_path)
    page = (tmp_path / "method.html").read_text()
    for text in ("2026-01-01", "no certificate", "no truth: it is chaotic"):
        assert text in page
    assert "somebody" in page


def test_a_truth_known_afresh_is_held_to_its_certificate():
    scene = scenes.make("pendulum")
    truth = seek_truth(scene, grid(scene))
    assert isinstance(truth, Truth)
    facts = truth_facts("pendulum", scene, truth)
    assert facts.certified
    assert facts.departs_by is not None
    assert facts.departs_by < 1e-10
    moved = replace(truth, position=truth.position + 1.0)
    assert (truth_facts("pendulum", scene, moved).departs_by or 0.0) > 1.0
