"""Compliance, energy drift and error over time, one line an engine."""

from __future__ import annotations

from typing import Any

from cross_checks.records.record import Record
from reports.drawing.numbers import setting
from reports.drawing.plots.figure import add_series, lines, new_figure, to_data
from reports.drawing.plots.palette import styles
from reports.facts.cheapest import best_of_engines


def compliance(records: list[Record]) -> dict[str, Any] | None:
    """Return the figure of the largest |C(q, t)| (m, rad) over time (s)."""
    return _history(records, "compliance_position", "largest |C(q, t)|, m or rad")


def energy(records: list[Record]) -> dict[str, Any] | None:
    """Return the figure of |E(t) - E(0) - work| (J) over time (s)."""
    return _history(records, "energy_drift", "|energy − initial − work|, J")


def error_history(records: list[Record]) -> dict[str, Any] | None:
    """Return the figure of the error over the scene's scales over time (s)."""
    return _history(records, "error", "error over the scene's scales")


def _history(records: list[Record], key: str, title: str) -> dict[str, Any] | None:
    """Return the figure of `history[key]` over time (s), or None where no record holds it."""
    drawn = [r for r in best_of_engines(records) if r.history.get(key) and r.history.get("t")]
    if not drawn:
        return None
    chosen = styles(records)
    drawn.sort(key=lambda r: list(chosen).index((r.engine, r.method)))
    figure = new_figure("time, s", title, x_log=False)
    figure.update_yaxes(dtick=None, nticks=10)
    for record in drawn:
        label = lines(f"{record.engine} · {record.method}", setting(record.settings))
        hover = f"{label}<br>%{{y:.2e}} at %{{x:.3g}} s<extra></extra>"
        style = chosen[record.engine, record.method]
        # the first sample is zero by construction and would stretch the axis
        x, y = record.history["t"][1:], record.history[key][1:]
        add_series(figure, record.engine, record.method, style, x, y, mode="lines", hovertemplate=hover)
    return to_data(figure)
