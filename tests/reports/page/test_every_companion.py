"""The companions of the pages, CSV, Markdown, LaTeX and the board: every figure of every row, from random runs."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from html import unescape
from statistics import median
from types import SimpleNamespace
from typing import Any

import pytest

from cross_checks import metrics
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import MEANINGS, OURS, WRONG, Cell, Verdict
from cross_checks.metrics.errors import COMPONENTS
from cross_checks.records.numbers import metres, of_scene, setting, short
from cross_checks.records.record import BUSY_NOTE
from reports.commands.publish.board import board
from reports.facts.report_data import ReportData
from reports.page import build, files
from reports.page.files import price_rows
from reports.page.render import plain, tex
from reports.page.slug import command
from tests.reports.page.test_recomputed_pages import at_target, shown, value
from tests.reports.page.test_shown_figures import LINKS, irregular, ratios

SEEDS = range(2)
TIMES = ("build_s", "first_call_s", "loop_s", "loop_median_s", "loop_most_s", "loop_runs")


def report(seed: int) -> ReportData:
    """Return an irregular report in which some figures of each run are unknown or bounded, some cells refused."""
    data = irregular(seed)
    every = list(metrics.every())
    records = []
    for k, run in enumerate(data.records):
        measures = {name: None if (k + j) % 4 == 0 else 0.37 * k + j for j, name in enumerate(every)}
        bounds = {one.name: 0.01 * k + j for j, one in enumerate(COMPONENTS) if (k + j) % 3 == 0}
        error = run.error and replace(run.error, worst=f"position of rod {k}", truth=f"exact: {k}")
        records.append(
            replace(run, measures=measures, bounds=bounds, error=error, t_end=0.1 * k, message=f"because {k}")
        )
    refused = Cell("pendulum_chain", {"links": 3}, "strange", "rk4", Verdict.CANNOT, "it has no ropes")
    cells = [replace(c, reason=f"a & b {k}", exemption="soft_ware" * (k % 3 == 0)) for k, c in enumerate(data.cells)]
    return replace(data, records=tuple(records), cells=(*cells, refused), environment={"made": "2026", "cpu": "x_1"})


@pytest.mark.parametrize("seed", SEEDS)
def test_every_column_of_the_csv(tmp_path, seed):
    data = report(seed)
    file = build.publish(data, tmp_path, "csv")
    with file.open(newline="") as text:
        rows = list(csv.DictReader(text))
    for row, run in zip(rows, data.records, strict=True):
        error = run.error
        figures: dict[str, Any] = {
            "scene": run.scene, "parameters": json.dumps(run.parameters), "engine": run.engine, "method": run.method,
            "setting": setting(run.settings), "status": run.status, "message": run.message, "t_end_s": run.t_end,
            "steps": run.steps, "rhs_calls": run.rhs_calls, "busy": BUSY_NOTE in run.notes, "command": command(run),
            "error": error and error.value, "error_m": error and error.value * error.length,
            "error_worst": error and error.worst, "truth_uncertainty": error and error.uncertainty,
            "truth": error and error.truth,
        }  # fmt: skip
        figures |= {f"{name} [{one.unit}]": run.measures[name] for name, one in metrics.every().items()}
        figures |= {f"{one.name} below [{one.unit}]": run.bounds.get(one.name) for one in COMPONENTS}
        figures |= {name: run.times.get(name) for name in TIMES}
        assert row == {name: "" if figure is None else str(figure) for name, figure in figures.items()}


def rows_of(text: str, sign: str) -> list[list[str]]:
    """Return the cells of the rows of all tables, whose cells a sign separates."""
    lines = [re.split(rf"(?<!\\){re.escape(sign)}", line) for line in text.splitlines()]
    return [[cell.strip().removesuffix("\\\\").strip() for cell in line if cell.strip()] for line in lines]


@pytest.mark.parametrize(("form", "sign", "escape"), [("md", "|", plain), ("latex", "&", tex)])
@pytest.mark.parametrize("seed", SEEDS)
def test_every_row_of_a_document(tmp_path, seed, form, sign, escape):
    """Prices as the pages show them, and every verdict with its figures."""
    data = report(seed)
    printed = rows_of(build.publish(data, tmp_path, form).read_text(), sign)
    for links in LINKS:
        for row in price_rows(data, f"pendulum_chain links={links}"):
            assert [escape(cell) for cell in row] in printed
    for cell in data.cells:
        row = [
            cell.engine,
            cell.method,
            cell.verdict,
            MEANINGS[cell.verdict].code,
            of_scene(cell.error),
            "–",
            cell.reason,
        ]
        assert [escape(text) for text in row] in printed
    assert [escape("cpu"), escape("x_1")] in printed


def cells_of(html: str) -> list[str]:
    """Return the texts of the cells of a row, without what small print adds and without its own link."""
    texts = re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", html, re.DOTALL)
    return [unescape(re.sub(r"<small>.*?</small>|<[^>]*>|#(?=</a>)", "", text)).strip() for text in texts]


@pytest.mark.parametrize("seed", SEEDS)
def test_every_figure_of_the_board(seed):
    data = report(seed)
    html = board(data).decode()
    rows = {name: cells_of(text) for name, text in re.findall(r'<tr id="([^"]+)"[^>]*>(.*?)</tr>', html, re.DOTALL)}
    for target in TARGETS:
        factors = {engine: own for engine, own in ratios(data, target).items() if own}
        hits = {links: at_target(data, links, target) for links in LINKS}
        for engine in {e for best in hits.values() for e in best}:
            own = factors.get(engine, [])
            row = rows.pop(f"rank-{short(target)}-{engine}")
            first = "not ranked" if engine == OURS else str(own.count(1.0))
            reached = sum(engine in best for best in hits.values())
            assert row == [f"{engine}", str(reached), first, f"{short(median(own))} ×" if own else "-"]
        for links, best in hits.items():
            for engine, run in best.items():
                row = rows.pop(next(name for name in rows if re.fullmatch(
                    rf"pendulum_chain-links=?{links}-{short(target)}-{engine}(-\w+)?", name)))  # fmt: skip
                assert run.error
                assert row[:2] == [engine, run.method]
                assert value(row[3]) == shown(run.error.value)
                assert value(row[4]) == shown(run.times["loop_s"], 3)
                assert row[6] == command(run)
    wrong = [c for c in data.cells if c.verdict in WRONG]
    titles = [html.index(f"<h3>{title}</h3>") for title in ("Engines", "Ours")] + [html.index('id="scenes"')]
    for c in wrong:
        name = next(name for name in rows if rows[name][:3] == [c.label, c.engine, c.method])
        row, k = rows.pop(name), int(c.engine == OURS)
        assert row[3].startswith(f"{c.verdict} : {c.reason}")
        assert row[3].endswith("adapter: soft_ware") == bool(c.exemption)
        assert row[4] == f"mbs-ref rerun {c.name}"
        assert titles[k] < html.index(f'id="{name}"') < titles[k + 1]
    missed = [row for row in rows.values() if len(row) > 2]
    assert not missed, "a figure that no run has"
    assert metres(None) == "–"


def test_tables_of_documents_have_a_heading_for_each_column(monkeypatch):
    seen: list[dict[str, Any]] = []
    template = SimpleNamespace(render=lambda context: seen.append(context) or "")
    monkeypatch.setattr(files, "templates", lambda: SimpleNamespace(get_template=lambda name: template))
    files.document(irregular(1), "any")
    assert list(seen[0]["price_head"]) == [
        "within", "engine", "method", "setting", "error", "loop time", "over the cheapest"]  # fmt: skip
    assert list(seen[0]["verdict_head"]) == ["engine", "method", "verdict", "code", "error", "setting", "why"]
    assert {len(row) for rows in seen[0]["prices"].values() for row in rows} == {7}
    assert {len(row) for rows in seen[0]["verdicts"].values() for row in rows} == {7}
