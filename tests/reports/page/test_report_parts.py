"""A part of the report that fails costs its own section, with the reason on the page."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace

from cross_checks.isolation.parent import direct
from cross_checks.records.store import Store
from reports import gather
from reports.facts.curves import Measured
from reports.facts.report_data import ReportData
from reports.page import build
from reports.page.render import render
from reports.studies import study
from tests.cross_checks.conftest import Swing, register
from tests.reports.page.measured_by_children import FOUND, made_up, part_made, what_was_made

STUDIES = {name: study.every()[name] for name in ("space", "sky", "contact")}


def test_a_study_that_raises_or_crashes_leaves_the_others(monkeypatch):
    monkeypatch.setattr(study, "every", lambda: STUDIES)
    monkeypatch.setattr(study, "measure", made_up)
    monkeypatch.setattr(study, "parts", lambda name: [])
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


def test_a_study_is_measured_after_its_parts(tmp_path, monkeypatch):
    (tmp_path / "made").mkdir()
    monkeypatch.setenv("MADE", str(tmp_path / "made"))
    monkeypatch.setattr(study, "every", lambda: {name: STUDIES[name] for name in ("space", "contact")})
    monkeypatch.setattr(study, "parts", lambda name: ["one", "two"] if name == "contact" else [])
    monkeypatch.setattr(study, "make", part_made)
    monkeypatch.setattr(study, "measure", what_was_made)
    found: dict[str, Measured] = {}
    with Store() as store:
        assert study.measure_all(store, found, (), lambda done, total, what: None) == []
    assert found["contact"].figures == {"one": 1, "two": 1}
    assert found.keys() == {"space", "contact"}
    assert sorted((tmp_path / "measured.txt").read_text().split()) == ["contact", "space"], "each is measured once"


def test_parts_are_measured_once_stored_and_joined(tmp_path, monkeypatch):
    """Tables of several parts are one; what is stored is measured again where its data files change."""
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "runs.sqlite"))
    measured = []

    def measure_part(part, *full):
        measured.append(part)
        return Measured({part: 1.0}, {"rows": ({"part": part},)})

    monkeypatch.setattr(study, "import_module", lambda name: SimpleNamespace(
        parts=lambda: ["one", "two"], measure_part=measure_part))  # fmt: skip
    monkeypatch.setattr(study, "_sources", lambda name: ["code"])
    study.make("contact", "two")
    found = study.measure("contact")
    assert measured == ["two", "one"]
    assert found == Measured({"one": 1.0, "two": 1.0}, {"rows": ({"part": "one"}, {"part": "two"})})
    monkeypatch.setattr(study, "_sources", lambda name: ["code", "other data"])
    study.measure("contact")
    assert measured == ["two", "one", "one", "two"]


def test_the_page_says_why_a_section_is_missing():
    page = render(ReportData((), (), incomplete="section space: <no root>"))["space.html"].decode()
    assert "Missing: section space: &lt;no root&gt;." in page
    assert "a quick one does not" in render(ReportData((), (), quick=True))["space.html"].decode()


def test_pages_grow_while_verdicts_come_and_an_interrupt_while_one_is_written_keeps_them(tmp_path, monkeypatch):
    register(Swing(), monkeypatch)
    monkeypatch.setattr(gather, "preparations", lambda store: [])
    monkeypatch.setattr(build, "PATIENCE", 0.0)
    monkeypatch.setattr(build, "LEAST_APART", 0.0)
    shown: list[ReportData] = []

    def published(data: ReportData, folder: Path, form: str = build.HTML) -> Path:
        shown.append(data)
        if len(shown) == 2:
            raise KeyboardInterrupt
        return folder

    monkeypatch.setattr(build, "publish", published)
    with Store(tmp_path / "runs.sqlite") as store:
        stages = gather.Gathering(store, call=direct, scenes=("pendulum",)).stages()
        _, incomplete = build.write_report(tmp_path / "out", stages)
    assert [len(data.cells) for data in shown] == [1, 2, 2]
    assert shown[0].incomplete == "still being computed: 3 of 4 verdicts"
    assert incomplete == "interrupted after 2 of 4 cells"
    assert build.read_data(tmp_path / "out").cells == shown[-1].cells
