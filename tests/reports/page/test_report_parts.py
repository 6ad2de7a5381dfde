"""A part of the report that fails costs its own section, with the reason on the page."""

from __future__ import annotations

import os
from math import sqrt

from cross_checks.records.store import Store
from reports.facts import gather
from reports.facts.report_data import ReportData
from reports.page.render import render

STUDIES = {"space": float, "sky": float, "contact": int}


def test_a_study_that_raises_or_crashes_leaves_the_others(monkeypatch):
    monkeypatch.setattr(gather, "STUDIES", STUDIES)
    monkeypatch.setattr(gather, "measure_study", made_up)
    found: dict[str, object] = {}
    with Store() as store:
        failed = gather.study(store, found, lambda done, total, what: None)
        assert found == {"contact": 7}
        assert sorted(told.partition(":")[0] for told in failed) == ["section sky", "section space"]
        assert any("its process was ended" in told for told in failed)
        found.clear()
        monkeypatch.setattr(gather, "measure_study", os.abort)
        monkeypatch.setattr(gather, "STUDIES", {"contact": int})
        assert gather.study(store, found, lambda done, total, what: None) == []
        assert found == {"contact": 7}, "what was measured is kept"


def test_the_page_says_why_a_section_is_missing():
    page = render(ReportData((), (), incomplete="section space: <no root>"))["space.html"].decode()
    assert "Missing: section space: &lt;no root&gt;." in page
    assert "a quick one does not" in render(ReportData((), (), quick=True))["space.html"].decode()


def made_up(name: str) -> object:
    """Importable by name, as a child process needs it."""
    if name == "sky":
        os.abort()
    return sqrt(-1.0) if name == "space" else 7
