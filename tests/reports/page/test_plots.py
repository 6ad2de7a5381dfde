"""Every plot of the pages is one that plotly's own checks accept."""

from __future__ import annotations

import json
import re

import plotly.graph_objects as go
import pytest

from cross_checks.records.plots import new_figure
from reports.page.render import render
from tests.reports.page.synthetic_report import report_data

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
