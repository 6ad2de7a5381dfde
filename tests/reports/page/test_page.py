"""The pages from a made-up report: complete, offline, escaped, small, and equal to their plain companions."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from cross_checks.records.numbers import duration, metres, setting, short
from mbs_ref import scenes
from reports.facts.report_data import ReportData
from reports.page.advice import advice
from reports.page.build import DATA, publish, read_data, write_report
from reports.page.render import pages
from reports.page.sections.prices import price_table
from reports.page.slug import engine_file, scene_file
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
    return write_report(tmp_path_factory.mktemp("report") / "out", ((lambda: data) for _ in range(1)))[0].parent


@pytest.fixture(scope="module")
def sources(folder) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.html")}


@pytest.fixture(scope="module")
def read(sources) -> dict[str, Page]:
    return {name: Page(source) for name, source in sources.items()}


def test_pages_load_their_own_files_alone(read, sources, folder):
    for name, page in read.items():
        loads = {load.partition("#")[0] for load in page.loads if not load.startswith("data:")} - {""}
        assert all((folder / load).is_file() for load in loads), name
        assert "default-src 'none'" in sources[name]
        assert "script-src 'self'" in sources[name]
    style = (folder / "style.css").read_text()
    assert "@import" not in style
    assert "url(" not in style


def test_no_page_is_large_to_open_and_the_first_begins_with_two_plots(folder, sources):
    assert all(len(source) < 2e6 for source in sources.values())
    first = sources["index.html"]
    assert len(first) < 2e5
    assert first.index('class="landscape"') < first.index('class="plot"') < first.index('class="findings"')
    assert "plotly" not in "".join(sources.values()), "it is loaded by page.js where a plot comes near the screen"


def test_text_from_records_is_escaped(read, sources):
    assert "<script>alert" not in "".join(sources.values())
    assert HOSTILE in "".join(text for page in read.values() for text in page.text)


def test_no_nan_reaches_a_page(read):
    for name, page in read.items():
        text = " ".join(page.text)
        assert not re.search(r"\b(nan|inf|infinity)\b", text + json.dumps(page.data), re.IGNORECASE), name
        assert not re.search(r"\b(None|undefined)\b", text), name


def test_every_cell_of_a_table_says_something(read):
    assert sum(len(page.cells) for page in read.values()) > 500
    for name, page in read.items():
        assert [cell for cell in page.cells if not cell.strip()] == [], name


def test_every_page_holds_its_sections_in_order_and_links_lead_to_all(data, sources, read):
    linked = {load.partition("#")[0] for load in read["index.html"].loads}
    for page in pages(data):
        names = [section.name for section in page.sections]
        assert re.findall(r'<section id="(\w+)"', sources[page.file]) == names
        assert page.file in linked


def test_every_cell_has_its_verdict_or_refusal_on_its_scenes_page(data, read):
    for cell in data.cells:
        text = " ".join(read[scene_file(cell.label)].text)
        assert cell.method in text
        assert (cell.verdict if cell.verdict != "cannot" else cell.reason) in text


@pytest.mark.parametrize(
    ("method", "scene", "told"),
    [
        ("implicitfast", "pendulum", "not tried: it would take about 1e+07 steps (implicitfast)"),
        ("implicitfast", "slider_crank", "not reached: its best is 0.3; finer settings do not help (implicitfast)"),
        ("tree_rk44", "slider_crank", "cannot: tree_rk44 cannot model a scene that is closed-loop"),
    ],
)
def test_a_target_that_is_not_reached_says_why(data, method, scene, told):
    alone = replace(data, cells=tuple(cell for cell in data.cells if cell.method == method))
    rows = {row["engine"]: row for row in price_table(alone, scene)[-1]["rows"]}
    assert told in [row["missed"] for row in rows.values()]


def test_an_engines_page_says_what_to_use_it_for_and_what_it_gets_wrong(data, read):
    text = " ".join(read[engine_file("mujoco")].text)
    assert "wrong with success reported" in text
    assert re.search(r"Use \w+ at (h|rtol) = ", text)
    lines = {line.engine: line for line in advice(data)}
    assert lines["mujoco"].silent[0].startswith("rk4, implicitfast: wrong-limit. Success is reported")
    assert [line.ours for line in lines.values()] == [False, False, False, True]


def test_a_method_is_not_advised_where_it_is_wrong(data):
    used = next(line.use for line in advice(data) if line.engine == "mujoco")
    method = used.split()[1]
    for cell in data.cells:
        if (cell.engine, cell.method, cell.verdict) == ("mujoco", method, "wrong-limit"):
            (best,) = [c.method for c in data.cells_of(cell.label, "mujoco") if c.targets[1].answer == "reached"]
            assert f", {best} on {cell.label}" in used


def test_our_own_solver_is_outside_the_ranking(data):
    for block in price_table(data, "pendulum"):
        engines = [row["engine"] for row in block["rows"]]
        assert engines[-1] == "mbs_ref"
        assert "cheapest" not in [row.get("factor") for row in block["rows"] if row["ours"]]


def test_rendering_again_from_the_kept_data_gives_the_same_pages(folder, data, tmp_path):
    kept = read_data(folder)
    assert kept == data
    again = publish(kept, tmp_path).parent
    for path in folder.iterdir():
        if path.name != DATA:
            assert path.read_bytes() == (again / path.name).read_bytes(), path.name


def test_jsonl_holds_the_records(folder, data):
    lines = (folder / "records.jsonl").read_text().splitlines()
    assert [json.loads(line) for line in lines] == [json.loads(json.dumps(r.to_dict())) for r in data.records]


def test_markdown_shows_every_cell_and_is_escaped(folder, data):
    text = (folder / "report.md").read_text()
    assert "<script>" not in text
    for cell in data.cells:
        assert f"| {cell.engine} | {cell.method} | {cell.verdict} | {cell.code} |" in text


def test_every_record_and_every_cell_has_its_command(data, sources):
    for scene in data.scenes:
        source = sources[scene_file(scene)]
        assert source.count('data-command="mbs-ref simulate') >= len(data.of_scene(scene))
        ran = [cell for cell in data.cells if cell.label == scene and cell.verdict != "cannot"]
        assert source.count('data-command="mbs-ref rerun') == len(ran)


def test_hover_text_is_escaped(read):
    blocks = [block for page in read.values() for block in page.data]
    traces = [trace for figure in blocks if isinstance(figure, dict) for trace in figure["data"]]
    texts = [text for trace in traces for text in trace.get("text") or []]
    assert texts
    assert not [t for t in texts if re.search(r"<(?!br>)", t)]


def test_a_report_without_any_run_still_renders(tmp_path):
    text = publish(ReportData((), ()), tmp_path).read_text()
    assert "No validation was run" in text


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
    assert scenes.label("pendulum_chain", {"links": 3, "gravity": 9.81}) == "pendulum_chain links=3"
    assert scenes.label("pendulum", {"gravity": 1.62}) == "pendulum gravity=1.62"


HEADINGS = {
    "index": ["Engine by scene", "What accuracy costs, over all scenes", "What went wrong"],
    "scene": ["The mechanism", "Cost at equal error", "Verdicts by method", "Compliance over time", "Energy drift",
              "Convergence order", "Time split", "Truths", "Records and commands"],
    "engine": ["What to use it for", "Verdicts by method", "Extremes", "Capabilities"],
    "extremes.html": ["Extremes"], "findings.html": ["What went wrong"], "profiles.html": ["Performance profiles"],
    "capabilities.html": ["Capabilities"], "method.html": ["How it is judged and timed", "Truths", "Environment"],
}  # fmt: skip


def test_every_page_has_its_sections_in_their_order(data):
    listed = pages(data)
    kinds = [page.kind for page in listed]
    assert kinds == sorted(kinds, key=["index", "scene", "engine", "study", "more"].index)
    met = set()
    for page in listed:
        key = page.file if page.file in HEADINGS else page.kind
        met.add(key)
        if key in HEADINGS:
            assert [section.title for section in page.sections] == HEADINGS[key]
    assert met == {*HEADINGS, "study"}
