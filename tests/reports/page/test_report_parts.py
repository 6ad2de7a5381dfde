"""A part of the report that fails costs its own section, with the reason on the page."""

from __future__ import annotations

import os
from math import sqrt

from reports.page import gather
from reports.page.render import render
from reports.page.report_data import ReportData


def silent(done: int, total: int, what: str) -> None:
    pass


def test_a_part_that_raises_or_crashes_leaves_the_others(monkeypatch):
    parts = {"space": out_of_domain, "sky": os.abort, "contact": os.getpid}
    monkeypatch.setattr(gather, "PARTS", parts)
    found: dict[str, object] = {}
    told = gather.measure_parts(found, silent)
    assert list(found) == ["contact"]
    assert told.startswith("section space: ")
    assert "section sky: its process was ended" in told


def test_the_page_says_why_a_section_is_missing():
    page = render(ReportData((), (), incomplete="section space: <no root>"))
    assert "Missing: section space: &lt;no root&gt;." in page
    assert "a quick one does not" in render(ReportData((), (), quick=True))


def out_of_domain() -> float:
    """Importable by name, as a child process needs it."""
    return sqrt(-1.0)
