"""Pages of notebooks and pictures of the README, from outputs, figures and pages that are made up."""

from __future__ import annotations

import base64
import io
import json
import re
import subprocess
from html import unescape
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from PIL import Image

from cross_checks.judge.runs import Runs
from cross_checks.records.record import Record
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from reports.page import build
from reports.page.render import ALL
from reports.site import __main__ as site
from reports.site import gallery, notebooks, pictures
from tests.reports.page.synthetic_report import report_data


def output(kind: str, **more: Any) -> Any:
    return SimpleNamespace(output_type=kind, **more)


def test_a_page_of_a_notebook_holds_every_cell_and_the_richest_form_of_every_output():
    figure = {"data": [{"y": [1]}], "layout": {"title": "</script>"}, "config": {}}
    plain = {"text/plain": "a < b\n\n\nc  "}
    rich = {"text/html": "<b>\n\n  \nrich</b>"} | plain
    outputs = [output("stream", text="said &\n"),
               output("display_data", data={notebooks.FIGURE: figure, "text/html": "x"} | plain),
               output("execute_result", data=rich), output("execute_result", data=plain), output("error")]  # fmt: skip
    cells = [SimpleNamespace(cell_type="markdown", source="# Title"),
             SimpleNamespace(cell_type="code", source="run()", outputs=outputs),
             SimpleNamespace(cell_type="code", source="again()", outputs=[outputs[1]])]  # fmt: skip
    text = notebooks.page(SimpleNamespace(cells=cells), "tour")
    parts = text.split("\n\n")
    assert parts[:2] == ["# Title", "```python\nrun()\n```"]
    assert parts[2] == "<pre>said &amp;</pre>"
    drawn = dict(re.findall(r'data-figure="([^"]*)">(.*?)</script>', text))
    kept = {"data": figure["data"], "layout": figure["layout"]}
    assert {name: json.loads(one) for name, one in drawn.items()} == {"tour-1-1": kept, "tour-2-0": kept}
    assert all(f'<div id="{name}"></div>' in text for name in drawn)
    assert "<div><b>\nrich</b></div>" in text
    assert "<pre>a &lt; b\n&#8203;\n\nc</pre>" in text
    assert text.index("rich") < text.index("a &lt; b") < text.index("again()")
    assert f'<script src="{notebooks.SCRIPT}"></script>' in text
    assert "[This page as a notebook](tour.ipynb)" in text


def test_every_notebook_becomes_a_page_beside_it(monkeypatch, tmp_path):
    folder = tmp_path / "notebooks"
    folder.mkdir()
    for name in ("b", "a"):
        (folder / f"{name}.ipynb").write_text(name)
    ran: list[str] = []
    monkeypatch.setattr(notebooks, "executed", lambda file: ran.append(file.name) or file.read_text())
    monkeypatch.setattr(notebooks, "page", lambda notebook, name: f"{notebook} under {name}")
    notebooks.write_pages(tmp_path)
    assert ran == ["a.ipynb", "b.ipynb"]
    assert {file.name: file.read_text() for file in folder.glob("*.md")} == {
        f"{name}.md": f"{name} under {name}" for name in "ab"}  # fmt: skip
    assert "Plotly" in (folder / notebooks.SCRIPT).read_text()[:10_000]


def picture(size: tuple[int, int], colour: str) -> bytes:
    buffer = io.BytesIO()
    Image.new("RGBA", size, colour).save(buffer, "PNG")
    return buffer.getvalue()


def test_pictures_show_the_scene_of_the_report_in_their_own_size(monkeypatch, tmp_path):
    """The plot has the frontiers of the scene's own records; every page is drawn in its window."""
    data = report_data()
    build.write_data(data, tmp_path)
    asked: list[Any] = []

    def drawn(address: str, option: str, window: str) -> bytes:
        text = Path(address.removeprefix("file://").partition("#")[0]).read_text(encoding="utf-8")
        asked.append((address, option, window, text))
        return picture((7, 5), "red")

    (tmp_path / "index.html").write_text("the first screen")
    monkeypatch.setattr(pictures, "drawn", drawn)
    seen: list[Any] = []
    monkeypatch.setattr(pictures, "simulate", lambda scene, settings: scene.name)
    monkeypatch.setattr(
        pictures, "filmstrip", lambda scene, path, count: seen.append((scene.name, path, count)) or b"s"
    )
    plot = pictures.work_precision
    monkeypatch.setattr(
        pictures, "work_precision", lambda records: seen.append({r.label for r in records}) or plot(records)
    )
    for name, size in (("report.png", pictures.SCREEN), ("mechanism.png", pictures.PANEL)):
        shown = Image.open(io.BytesIO(pictures.PICTURES[name](tmp_path)))
        assert (shown.size, shown.mode) == ((7, 5), "RGB")
        assert asked[-1][1:3] == ("--screenshot", f"--window-size={size[0]},{size[1]}")
    assert asked[0][3] == "the first screen"
    assert seen == [("pendulum_chain", "pendulum_chain", 4), {"pendulum_chain links=3"}]
    page = asked[1][3]
    assert base64.b64encode(b"s").decode() in page
    (figure,) = re.findall(r'Plotly.newPlot\(\s*"[^"]*",\s*(\[.*?\]),\s*\{"', page, re.DOTALL)
    lines = json.loads(figure)
    assert lines
    assert all(line["name"] == line["legendgroup"] and "visible" not in line for line in lines)
    assert pictures.swing(tmp_path) == b"s"
    assert seen[-1][1:] == (seen[-1][0], 4)


def test_the_terminal_shows_the_command_and_what_it_prints(monkeypatch, tmp_path):
    ran: list[Any] = []
    done = SimpleNamespace(stdout="one line\nanother   \n\n")
    monkeypatch.setattr(pictures.subprocess, "run", lambda command, **more: ran.append((command, more)) or done)
    svg = pictures.terminal(tmp_path).decode()
    text = unescape(re.sub(r"<[^>]*>", "", svg)).replace("\xa0", " ")
    assert [text.find(part) > 0 for part in (f"$ {pictures.SESSION}", "one line", "another")] == [True] * 3
    ((command, more),) = ran
    assert [command[0].name, *command[1:]] == pictures.SESSION.split()
    assert more["check"]


def test_a_browser_draws_a_page_into_a_file_of_its_own(monkeypatch, tmp_path):
    """A print of a report is of its single file, with every page shown."""
    asked: list[list[str]] = []

    def run(words: list[str], **more: Any) -> subprocess.CompletedProcess:
        asked.append(words)
        target = next(word for word in words if word.startswith(("--screenshot=", "--print-to-pdf=")))
        Path(target.partition("=")[2]).write_bytes(b"drawn")
        return subprocess.CompletedProcess(words, 0, b"printed")

    monkeypatch.setattr(build.shutil, "which", {"google-chrome": "/bin/google-chrome"}.get)
    monkeypatch.setattr(build.subprocess, "run", run)
    assert build.drawn("file:///a.html", "--screenshot", "--window-size=3,4") == b"drawn"
    ((program, *words, address),) = asked
    assert (program, address) == ("/bin/google-chrome", "file:///a.html")
    assert {"--headless", "--window-size=3,4", f"--virtual-time-budget={build.LOADING_MS}"} <= set(words)
    monkeypatch.setattr(build, "single", lambda data: b"whole")
    seen: list[Any] = []

    def printed(address: str, *options: str) -> bytes:
        file, _, part = address.removeprefix("file://").partition("#")
        seen.append((Path(file).read_bytes(), part, options))
        return b"%PDF"

    monkeypatch.setattr(build, "drawn", printed)
    file = build.publish(report_data(), tmp_path, "pdf")
    assert (file.name, file.read_bytes()) == ("report.pdf", b"%PDF")
    assert seen.pop() == (b"whole", ALL, ("--print-to-pdf", "--no-pdf-header-footer"))
    static = b"""<style>@media print {}</style><svg></svg><a href="scene-a-b=1.html#x"></a><a href="https://a.b/c.html"></a>"""
    needless = b"<script>1\n</script>", b'<script type="application/json">{}</script>', b"<noscript>no</noscript>"
    monkeypatch.setattr(build, "loaded", lambda *words: printed(*words)[:0] + static + b"".join(needless))
    file = build.publish(report_data(), tmp_path, "static")
    expected = static.replace(b"media print", b"media all").replace(b"scene-a-b=1.html#x", b"#scene-a-b=1.html")
    assert (file.name, file.read_bytes()) == ("static.html", expected)
    assert seen == [(b"whole", ALL, ("--dump-dom", "--window-size=1400,1000"))]
    monkeypatch.undo()  # the browser itself is called again
    monkeypatch.setattr(build.shutil, "which", lambda name: None)
    with pytest.raises(FileNotFoundError, match="this needs one of chromium, "):
        build.drawn("a", "b")


# --- the gallery -------------------------------------------------------------------------------------------


def test_the_gallery_has_an_entry_a_scene_with_its_film_or_why_there_is_none(monkeypatch, tmp_path):
    path, reported = SimpleNamespace(times=[0.0, 1.0]), []
    monkeypatch.setattr(gallery, "filmed", lambda s: (None, "Not filmed: NaN") if s.name == "kepler" else (path, ""))
    monkeypatch.setattr(gallery, "beside", lambda scene, runs: [scene.name, runs])
    monkeypatch.setattr(gallery, "as_gif", lambda film, seconds: f"{film[0]} for {seconds:g} s".encode())
    monkeypatch.setattr(gallery, "as_page", lambda title, film, times, seconds: f"{title} {times}".encode())
    monkeypatch.setattr(gallery, "summary", lambda scene: SimpleNamespace(sentence=lambda: f"made of {scene.name}"))
    monkeypatch.setattr(
        gallery, "write_trade", lambda runs, scene, target: "" if scene.name == "kepler" else "no truth"
    )
    monkeypatch.setattr(gallery, "stored", lambda scene: SimpleNamespace(kind="exact", uncertainty=2e-9)
                        if scene.name == "kepler" else None)  # fmt: skip
    page = gallery.gallery(Runs(), ["pendulum", "kepler"], (), tmp_path, reported.append)
    assert reported == ["filming and timing kepler", "filming and timing pendulum"]
    assert page.index("kepler") < page.index("pendulum in motion")
    first, second = page.split("![pendulum in motion]")
    for part, name, words in (
        (first, "kepler", ("Not filmed: NaN.", "[work-precision plot](gallery/kepler-work-precision.html)",
                           "exact, known to 2.0e-09 m", "nobody that is installed")),
        (second, "pendulum", ("(gallery/pendulum.gif)", "[Go through it](gallery/pendulum.html)",
                              "not shown: no truth", "computed at its first use")),
    ):  # fmt: skip
        assert all(word in part for word in words), name
        assert f"`mbs-ref simulate {name}`" in part
        assert f"made of {name}" in part
    assert (tmp_path / "pendulum.gif").read_bytes() == b"pendulum for 4 s"
    assert (tmp_path / "pendulum.html").read_bytes() == b"pendulum [0.0, 1.0]"
    assert not (tmp_path / "kepler.gif").exists()


@pytest.mark.parametrize(("truth", "found", "said"), [
    (NoTruth("none"), [], "none"), ("known", [], "no engine's own choice of method reaches the end"),
    ("known", ["refused", "missing"], "no engine's own choice of method reaches the end"),
    ("known", ["quick", "refused", "slow"], ""),
])  # fmt: skip
def test_a_plot_of_the_gallery_holds_every_engine_that_takes_the_scene(monkeypatch, tmp_path, truth, found, said):
    scene, asked = scenes.make("double_pendulum"), []

    def get(name: str) -> Any:
        if name == "missing":
            raise gallery.engines.EngineMissing("no")
        return SimpleNamespace(method=lambda asked: f"default of {name}")

    def searched(runs: Any, scene: Any, name: str, method: str, truth: Any, targets: Any, most: int) -> Any:
        asked.append((name, method, targets, most))
        return SimpleNamespace(records={1: Record(scene.name, {}, name, "m", {}, "success")}), None

    drawn: list[Any] = []
    figure = SimpleNamespace(write_html=lambda target, include_plotlyjs: target.write_text(str(include_plotlyjs)))
    monkeypatch.setattr(gallery, "_plot_truth", lambda runs, scene: truth)
    monkeypatch.setattr(gallery, "entrants", lambda: found)
    monkeypatch.setattr(gallery.engines, "get", get)
    monkeypatch.setattr(gallery, "refusal_of", lambda scene, name, method: "no" if name == "refused" else "")
    monkeypatch.setattr(gallery, "search", searched)
    monkeypatch.setattr(gallery, "usable", lambda record: record.engine == "slow")
    monkeypatch.setattr(gallery, "work_precision", lambda records: drawn.append([r.engine for r in records]) or figure)
    assert gallery.write_trade(Runs(), scene, tmp_path / "plot.html") == said
    assert drawn == ([["quick", "slow"]] if not said else [])
    assert (tmp_path / "plot.html").exists() == (not said)
    assert asked == [(name, f"default of {name}", (1e-3, 1e-6), 25_000) for name in found if name in ("quick", "slow")
                     and truth == "known"]  # fmt: skip


@pytest.mark.parametrize("only", [None, ["pendulum"]])
def test_the_site_has_a_gallery_of_what_is_asked(monkeypatch, tmp_path, only):
    asked: list[Any] = []
    monkeypatch.setattr(site, "capabilities", tuple)
    monkeypatch.setattr(
        site, "gallery", lambda runs, shown, able, pictures, say: asked.append((shown, pictures)) or "gallery"
    )
    site.write_sources(tmp_path / "site", lambda text: None, only)
    assert asked == [(only or scenes.names(), tmp_path / "site" / "gallery")]
    assert (tmp_path / "site" / "gallery.md").read_text() == "gallery"
    pages = [page.read_text() for page in (tmp_path / "site").glob("*.md")]
    assert not any(re.search(r"\]\(\.\./(CHANGELOG|CONTRIBUTING)", page) for page in pages)
