"""Figures over the nights, with the places where their level changed."""

from __future__ import annotations

import html
from pathlib import Path

from benchmarks.history import Entry
from mbs_ref.atomic_file import write_atomic
from reports.drawing.plots.figure import new_figure

TITLES = {"1": "ratio to the job's own baseline", "s": "time, s"}


def write_trends(series: dict[str, list[Entry]], changes: dict[str, list[int]], target: Path) -> None:
    """Write one page that works offline: a figure a unit, and a ring round the first value of each new level."""
    units = list(dict.fromkeys(entries[0].unit for entries in series.values()))
    parts = []
    for unit in units:
        own = {name: entries for name, entries in series.items() if entries[0].unit == unit}
        figure = _figure(own, changes, TITLES.get(unit, unit), y_log=unit != "1")
        parts.append(figure.to_html(full_html=False, include_plotlyjs=not parts))
    page = f"<!doctype html><meta charset='utf-8'><title>mbs-ref: trends</title>{''.join(parts)}"
    write_atomic(target, page.encode())


def _figure(series: dict[str, list[Entry]], changes: dict[str, list[int]], title: str, y_log: bool):
    figure = new_figure("time of the job, UTC", title, x_log=False, y_log=y_log)
    for name, entries in series.items():
        x, y = [e.made for e in entries], [e.value for e in entries]
        told = [html.escape(f"{e.commit_id} {e.verdict}".strip()) for e in entries]
        hover = "%{y:.4g}, %{x}<br>%{text}"
        figure.add_scatter(x=x, y=y, mode="lines+markers", name=html.escape(name), text=told, hovertemplate=hover)
        marked = changes[name]
        figure.add_scatter(
            x=[x[k] for k in marked], y=[y[k] for k in marked], mode="markers", showlegend=False,
            marker={"symbol": "circle-open", "size": 16, "color": "#c0392b"}, hovertext="the level changed here",
        )  # fmt: skip
    return figure
