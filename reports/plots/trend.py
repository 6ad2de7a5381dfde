"""Figures over the nights, with the places where their level changed."""

from __future__ import annotations

import html
from pathlib import Path

from benchmarks.history import Entry
from mbs_ref.atomic import write_atomic
from reports.plots.figure import new_figure


def write_trends(series: dict[str, list[Entry]], changes: dict[str, list[int]], target: Path) -> None:
    """Write one page that works offline: every series, and a ring round the first value of each new level."""
    figure = new_figure("time of the job, UTC", "ratio to the job's baseline, or s", x_log=False)
    for name, entries in series.items():
        x, y = [e.made for e in entries], [e.value for e in entries]
        figure.add_scatter(x=x, y=y, mode="lines+markers", name=html.escape(name))
        marked = changes[name]
        figure.add_scatter(
            x=[x[k] for k in marked], y=[y[k] for k in marked], mode="markers", showlegend=False,
            marker={"symbol": "circle-open", "size": 16, "color": "#c0392b"}, hovertext="the level changed here",
        )  # fmt: skip
    write_atomic(target, figure.to_html(include_plotlyjs=True).encode())
