"""What the page says of the trade: performance profiles with their tables, and the truths behind every error."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.profiles import ERRORS, profiles
from cross_checks.certificates.certificate import Certificate, certify
from cross_checks.records.record import Record
from cross_checks.truth import NoTruth
from mbs_ref import scenes
from reports.page.publish import publish
from reports.page.report_data import ReportData
from reports.page.sections import truths
from reports.page.sections.profiles import context
from reports.page.sections.work_precision import equal_error_table
from reports.page.truth_facts import TruthFacts
from tests.reports.page.synthetic_report import report_data

DATA = report_data()


def test_a_profile_at_each_accuracy_with_its_table():
    blocks = context(DATA)["blocks"]
    assert len(blocks) == len(ERRORS)
    for block, error in zip(blocks, ERRORS, strict=True):
        solvers = [profile for profile in profiles(DATA.records, error) if profile.factors]
        assert len(block["rows"]) == len(block["plot"]["data"]) == len(solvers)
        for trace, profile in zip(block["plot"]["data"], solvers, strict=True):
            assert trace["y"] == sorted(trace["y"])
            assert trace["y"][-1] == pytest.approx(profile.solved)
            assert trace["line"]["shape"] == "hv"
    best = blocks[1]["rows"][0]
    assert best["shares"][0] == max((row["shares"][0] for row in blocks[1]["rows"]), key=lambda text: int(text[:-1]))


def unsure(record: Record) -> Record:
    """A record whose truth is known to 1e-9 m only."""
    return record if record.error is None else replace(record, error=replace(record.error, uncertainty=1e-9))


def test_what_a_truth_cannot_judge_is_not_ranked():
    hazy = [unsure(record) if record.scene == "pendulum" else record for record in DATA.records]
    count = {kind: profiles(records, 1e-9)[0].problems for kind, records in (("all", DATA.records), ("hazy", hazy))}
    assert count["hazy"] == count["all"] - 1
    blocks = equal_error_table(replace(DATA, records=tuple(hazy)), "pendulum")
    assert [bool(block["unjudged"]) for block in blocks] == [False, False, True]
    assert "judges no error below 3e-8 m" in blocks[-1]["unjudged"]


def test_truths_hold_depart_or_are_none(tmp_path):
    made = certify(scenes.make("pendulum"), confirm=False)
    assert isinstance(made, Certificate)
    moved = replace(made, end={name: [1.0, 1.0] for name in made.end}, confirmed_to=1e-12, confirmed_by="somebody")
    facts = (
        TruthFacts("pendulum", made, made),
        TruthFacts("moved", made, moved),
        TruthFacts("new", made, None),
        TruthFacts("none", NoTruth("it is chaotic"), None),
    )
    words = [truths.row(f).get("word", truths.row(f)["none"]) for f in facts]
    assert words == ["holds", "departs", "no certificate", "it is chaotic"]
    page = publish(ReportData((), (), truths=facts), tmp_path).read_text()
    assert "no truth: it is chaotic" in page
    assert "somebody" in page
