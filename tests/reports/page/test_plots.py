"""Every plot of the pages is one that plotly's own checks accept."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import plotly.graph_objects as go
import pytest

from benchmarks.history import Entry
from cross_checks.records import plots as of_runs
from cross_checks.records.plots import new_figure
from reports.commands.maintenance import history as trends
from reports.facts.report_data import standings
from reports.page.render import render
from reports.page.sections import overview, plots, profiles
from tests.reports.page.synthetic_report import report_data
from tests.reports.page.test_shown_figures import irregular

PLOT = re.compile(r'<script type="application/json"[^>]*>(.*?)</script>', re.DOTALL)


def test_plotly_accepts_every_plot_of_the_pages():
    pages = [page.decode() for name, page in render(report_data()).items() if name.endswith(".html")]
    plots = [found for page in pages for text in PLOT.findall(page) if "layout" in (found := json.loads(text))]
    assert len(plots) > 10
    for plot in plots:
        assert go.Figure(plot).to_plotly_json()["data"], "an unknown property raises ValueError"


def test_a_figure_with_an_unknown_property_is_refused_when_it_stands_alone():
    figure = new_figure("t, s", "x, m")
    figure.add_scatter(x=[1.0], y=[2.0], modde="lines")
    with pytest.raises(ValueError, match="modde"):
        figure.to_html()


ERROR, TIME = "error over the scene's scales", "time, s"


def drawn() -> dict[str, Any]:
    """Return every figure of runs by its name."""
    data = irregular(1)
    history = {"t": [0.0, 1.0, 2.0], "error": [0.0, 1e-9, 2e-9], "compliance_position": [0.0, 1e-9, 1e-9],
               "energy_drift": [0.0, 1.0, 2.0]}  # fmt: skip
    runs = [replace(run, history=history) for run in data.of_scene(data.scenes[0])]
    entry = Entry("job", "2026-01-01", "abc", "box", "series", 1.5, "s")
    return {
        "work_precision": of_runs.work_precision(runs), "compliance": of_runs.compliance(runs),
        "energy": of_runs.energy(runs), "error_history": of_runs.error_history(runs),
        "by step": plots.convergence(runs, "step", {}), "by tolerance": plots.convergence(runs, "rtol", {}),
        "time_split": plots.time_split(runs), "frontier": overview.frontier_plot(data),
        "profile": profiles.profile_plot(standings(data, 1e-6)),
        "trend": of_runs.to_data(trends._figure({"series": [entry]}, {"series": []}, trends.TITLES["s"], True)),
        "ratios": of_runs.to_data(trends._figure({"series": [entry]}, {"series": []}, trends.TITLES["1"], False)),
    }  # fmt: skip


def test_every_figure_has_its_titles_and_units_and_its_logarithmic_axes():
    axes = {
        "work_precision": ("time of the integration loop, ms", "log", ERROR, "log"),
        "compliance": (TIME, "-", "largest |C(q, t)|, m or rad", "log"),
        "energy": (TIME, "-", "|energy − initial − work|, J", "log"), "error_history": (TIME, "-", ERROR, "log"),
        "by step": ("step h, s", "log", ERROR, "log"), "by tolerance": ("relative tolerance", "log", ERROR, "log"),
        "time_split": ("time, ms", "-", "", "category"),
        "frontier": ("loop time over that of the cheapest ranked engine at 1e-6", "log", ERROR, "log"),
        "profile": ("times the best loop time, tau", "log", "share of the problems solved, rho", "-"),
        "trend": ("time of the job, UTC", "-", TIME, "log"),
        "ratios": ("time of the job, UTC", "-", "ratio to the job's own baseline", "-"),
    }  # fmt: skip
    found = {name: figure["layout"] for name, figure in drawn().items()}
    for name, layout in found.items():
        x, y = layout["xaxis"], layout["yaxis"]
        assert (x["title"]["text"], x["type"], y["title"]["text"], y["type"]) == axes[name], name
    bars = drawn()["time_split"]["data"]
    assert [(bar["name"], bar["marker"]["color"]) for bar in bars] == [
        ("build the model", "#9aa7b5"), ("first call (compile, allocate)", "#c9a227"),
        ("integration loop", "#2b7bd6")]  # fmt: skip
    assert found["work_precision"]["height"] == 540
