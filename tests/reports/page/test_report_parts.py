"""A part of the report that fails costs its own section, with the reason on the page."""

from __future__ import annotations

import os
from math import sqrt

from cross_checks.records.store import Store
from reports.facts.curves import Measured
from reports.facts.report_data import ReportData
from reports.page.render import render
from reports.studies import study

STUDIES = {name: study.every()[name] for name in ("space", "sky", "contact")}
FOUND = Measured({"answer": 7})


def test_a_study_that_raises_or_crashes_leaves_the_others(monkeypatch):
    monkeypatch.setattr(study, "every", lambda: STUDIES)
    monkeypatch.setattr(study, "measure", made_up)
    found: dict[str, Measured] = {}
    with Store() as store:
        failed = study.measure_all(store, found, (), lambda done, total, what: None)
        assert found == {"contact": FOUND}
        assert sorted(sentence.partition(":")[0] for sentence in failed) == ["section sky", "section space"]
        assert any("its process was ended" in sentence for sentence in failed)
        found.clear()
        monkeypatch.setattr(study, "measure", os.abort)
        monkeypatch.setattr(study, "every", lambda: {"contact": STUDIES["contact"]})
        assert study.measure_all(store, found, (), lambda done, total, what: None) == []
        assert found == {"contact": FOUND}, "what was measured is stored"


def test_the_page_says_why_a_section_is_missing():
    page = render(ReportData((), (), incomplete="section space: <no root>"))["space.html"].decode()
    assert "Missing: section space: &lt;no root&gt;." in page
    assert "a quick one does not" in render(ReportData((), (), quick=True))["space.html"].decode()


def made_up(name: str) -> object:
    """Importable by name, as a child process needs it."""
    if name == "sky":
        os.abort()
    return sqrt(-1.0) if name == "space" else FOUND
