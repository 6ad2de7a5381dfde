"""A part of the report that fails costs its own section, with the reason on the page."""

from __future__ import annotations

import os
from math import sqrt

from cross_checks.records.store import Store
from reports.facts.report_data import ReportData
from reports.page.render import render
from reports.studies import measuring
from reports.studies.study import Study

KINDS = {"space": float, "sky": float, "contact": int}
STUDIES = {name: Study(f"{name}.html", name, kind) for name, kind in KINDS.items()}


def test_a_study_that_raises_or_crashes_leaves_the_others(monkeypatch):
    monkeypatch.setattr(measuring, "measured", lambda: STUDIES)
    monkeypatch.setattr(measuring, "measure", made_up)
    found: dict[str, object] = {}
    with Store() as store:
        failed = measuring.measure_all(store, found, (), lambda done, total, what: None)
        assert found == {"contact": 7}
        assert sorted(told.partition(":")[0] for told in failed) == ["section sky", "section space"]
        assert any("its process was ended" in told for told in failed)
        found.clear()
        monkeypatch.setattr(measuring, "measure", os.abort)
        monkeypatch.setattr(measuring, "measured", lambda: {"contact": STUDIES["contact"]})
        assert measuring.measure_all(store, found, (), lambda done, total, what: None) == []
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
