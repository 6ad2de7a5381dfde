"""The page from a made-up report: complete, offline, escaped, and equal to its plain companions."""

from __future__ import annotations

import csv
import json
import re
from html.parser import HTMLParser

import pytest

from reports.page.contents import SECTIONS
from reports.page.numbers import duration, metres, setting, short
from reports.page.plots.palette import COLOURS, colours
from reports.page.publish import publish
from reports.page.report_data import ReportData
from reports.reproduce import command, scene_label
from tests.reports.page.synthetic_report import HOSTILE, report_data

LOADING = {"src", "href", "data", "poster", "action", "srcset"}  # attributes that make a browser fetch


class Page(HTMLParser):
    """Gathers what the tests ask: loads, table cells, inline script, data blocks and visible text."""

    def __init__(self, text: str):
        super().__init__()
        self.loads, self.cells, self.text, self.data = [], [], [], []
        self.inside: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.loads += [found[name] for name in LOADING & found.keys()]
        if tag in ("td", "th", "dd"):
            self.cells.append("")
        if tag in ("script", "style"):
            self.inside.append("json" if found.get("type") == "application/json" else tag)

    def handle_endtag(self, tag):
        if tag in ("script", "style"):
            self.inside.pop()

    def handle_data(self, data):
        kind = self.inside[-1] if self.inside else "text"
        if kind == "json":
            self.data.append(json.loads(data, parse_constant=pytest.fail))
        if kind == "text":
            self.text.append(data)
            if self.cells:
                self.cells[-1] += data


@pytest.fixture(scope="module")
def data() -> ReportData:
    return report_data()


@pytest.fixture(scope="module")
def folder(data, tmp_path_factory):
    return publish(data, tmp_path_factory.mktemp("report") / "out").parent


@pytest.fixture(scope="module")
def source(folder) -> str:
    return (folder / "index.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(source) -> Page:
    return Page(source)


def test_the_page_loads_nothing(page, source):
    assert all(load.startswith(("#", "data:")) for load in page.loads)
    assert "default-src 'none'" in source
    style = source[source.index("<style>") : source.index("</style>")]
    assert "@import" not in style
    assert "url(" not in style


def test_text_from_records_is_escaped(page, source):
    assert "<script>alert" not in source
    assert HOSTILE in "".join(page.text)


def test_no_nan_reaches_the_page(page):
    text = " ".join(page.text) + json.dumps(page.data)
    assert not re.search(r"\b(nan|inf|infinity)\b", text, re.IGNORECASE)
    assert not re.search(r"\b(None|undefined)\b", " ".join(page.text))


def test_every_cell_says_something(page):
    assert len(page.cells) > 500
    assert [cell for cell in page.cells if not cell.strip()] == []


def test_every_section_is_there_once_in_order(page, source):
    names = [section.name for section in SECTIONS]
    assert re.findall(r'<section id="(\w+)"', source) == names
    assert {f"#{name}" for name in names} <= set(page.loads)


def test_the_matrix_holds_every_cell(data, source):
    assert source.count('popover="') + source.count(" popover>") == len(data.cells)


def test_verdict_names_the_wrong_limit(page):
    text = " ".join(page.text)
    scenes = "n_four_bar loops=1, n_four_bar loops=2, slider_crank"
    assert f"mujoco rk4, implicitfast on {scenes} converges to another answer." in text


def test_jsonl_holds_the_records(folder, data):
    lines = (folder / "records.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == [json.loads(json.dumps(r.to_dict())) for r in data.records]


def test_csv_agrees_with_the_records(folder, data):
    with (folder / "records.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(data.records)
    for row, record in zip(rows, data.records, strict=True):
        assert (row["engine"], row["method"], row["status"]) == (record.engine, record.method, record.status)
        assert float(row["loop_s"]) == record.times["loop_s"]
        assert row["error_m"] == ("" if record.error is None else repr(record.error.value))
        assert row["command"] == command(record)


def test_markdown_shows_the_matrix_and_is_escaped(folder, data):
    text = (folder / "report.md").read_text()
    assert "<script>" not in text
    for cell in data.cells:
        assert cell.verdict in text
    header = next(line for line in text.splitlines() if line.startswith("| engine and method"))
    assert header.count("|") == len(data.scenes) + 2


def test_every_record_has_its_command(data, source):
    assert source.count("data-command=") == len(data.records)


def test_the_command_reproduces_the_settings(data):
    record = next(r for r in data.records if r.scene == "n_four_bar" and r.settings.get("step"))
    assert command(record) == (
        "mbs-ref simulate n_four_bar -p loops=1 --engine mbs_ref --method rk4 --step 0.01 --t-end 10.0 --samples 41"
    )


def test_hover_text_is_escaped(page):
    traces = [trace for figure in page.data if isinstance(figure, dict) for trace in figure["data"]]
    texts = [text for trace in traces for text in trace.get("text") or []]
    assert texts
    assert not [t for t in texts if re.search(r"<(?!br>)", t)]


def test_a_report_without_any_run_still_renders(tmp_path):
    text = publish(ReportData((), ()), tmp_path).read_text()
    assert "No validation was run" in text


def test_nothing_is_left_beside_the_four_files(folder):
    assert sorted(p.name for p in folder.iterdir()) == ["index.html", "records.csv", "records.jsonl", "report.md"]


def test_an_engine_keeps_its_colour(data):
    assert colours(data.engines)["mbs_ref"] == COLOURS[0]
    assert len(set(colours(data.engines).values())) == len(data.engines)


@pytest.mark.parametrize(
    ("value", "text"),
    [(3.2e-7, "3.2e-7"), (1e-6, "1e-6"), (0.0, "0"), (float("nan"), "–"), (None, "–"), (0.5, "0.5"), (123.4, "120")],
)
def test_short_numbers(value, text):
    assert short(value) == text


def test_units():
    assert (metres(1e-6), metres(None)) == ("1e-6 m", "–")
    assert (duration(1.5), duration(2e-3), duration(3e-5)) == ("1.5 s", "2 ms", "30 µs")
    assert setting({"rtol": 1e-9, "atol": 1e-9, "stabilization": "projection"}) == "rtol = 1e-9, projection"


def test_labels_show_counts_and_what_was_chosen():
    assert scene_label("pendulum_chain", {"links": 3, "gravity": 9.81}) == "pendulum_chain links=3"
    assert scene_label("pendulum", {"gravity": 1.62}) == "pendulum gravity=1.62"
