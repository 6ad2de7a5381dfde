"""Text from scene files and records cannot become markup: neither elements nor attributes nor scripts."""

from __future__ import annotations

import json
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from cross_checks.judge.capabilities import Ability
from cross_checks.judge.one_run import evaluate
from cross_checks.records.lines import adapter
from cross_checks.records.record import Record
from mbs_ref.scene.toml import SceneFileError, loads
from mbs_ref.settings import Settings
from reports.facts.report_data import ReportData
from reports.page.build import publish
from tests.reports.page.synthetic_report import report_data

HOSTILE = """'"></td></script><script>alert(1)</script><img src=x onerror=alert(2)>&lt;{{7*7}}|"""
SCENE = f"""
name = "swing"
description = '''{HOSTILE}'''
source = '''{HOSTILE}'''
gravity = [0.0, -9.81]
duration = 0.1
[parameters]
{json.dumps(HOSTILE)} = {json.dumps(HOSTILE)}
[[bodies]]
type = "planar"
name = "rod"
mass = 1.0
inertia = 0.1
position = [0.5, 0.0]
[[joints]]
type = "revolute"
name = "pin"
body_a = "ground"
body_b = "rod"
point = [0.0, 0.0]
"""


class Elements(HTMLParser):
    """Counts elements and gathers event handlers and what would be fetched."""

    def __init__(self, text: str):
        super().__init__()
        self.scripts, self.bad = 0, []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.scripts += tag == "script"
        self.bad += [(tag, name, value) for name, value in attrs if name.startswith("on") or value == "x"]


def page_of(data: ReportData, folder) -> Elements:
    """Read every page as one."""
    publish(data, folder)
    return Elements(source_of(folder))


def source_of(folder) -> str:
    return "".join(path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.html")))


def hostile(data: ReportData) -> ReportData:
    """Put the text wherever a record or cell holds words of its own."""
    words = {"message": HOSTILE, "notes": (HOSTILE,), "versions": {HOSTILE: HOSTILE}, "parameters": {HOSTILE: HOSTILE}}
    records = tuple(replace(r, scene=r.scene + HOSTILE, method=r.method + HOSTILE, **words) for r in data.records)
    cells = tuple(replace(c, scene=c.scene + HOSTILE, method=c.method + HOSTILE, reason=HOSTILE) for c in data.cells)
    able = tuple(
        replace(c, reason=HOSTILE, traits={HOSTILE: Ability("never", HOSTILE)}, parts={HOSTILE: True})
        for c in data.capabilities
    )
    facts = {HOSTILE: HOSTILE, "made": HOSTILE}
    return replace(data, records=records, cells=cells, environment=facts, capabilities=able, incomplete=HOSTILE)


def test_hostile_records_add_no_element(tmp_path):
    page, plain = page_of(hostile(report_data()), tmp_path / "a"), page_of(report_data(), tmp_path / "b")
    assert page.bad == []
    assert page.scripts <= plain.scripts + 2 * len(report_data().records)  # a block of data more a plot, none that runs
    source = source_of(tmp_path / "a")
    assert "<script>alert" not in source
    assert "<img src=x" not in source


def test_a_hostile_scene_file_is_read_judged_and_shown_as_text(tmp_path):
    record = evaluate(loads(SCENE), "mbs_ref", Settings(samples=5))
    assert record.status == "success"
    again = adapter(Record).validate_json(json.dumps(record.to_dict()))
    page = page_of(ReportData((), (again,)), tmp_path / "out")
    assert page.bad == []
    source = source_of(tmp_path / "out")
    assert "<script>alert" not in source
    assert "<img src=x" not in source


@pytest.mark.parametrize("old", ['"swing"', '"rod"', '"pin"'])
def test_names_are_words_only(old):
    with pytest.raises(SceneFileError, match="letters, digits"):
        loads(SCENE.replace(old, '"<script>alert(1)</script>"'))
