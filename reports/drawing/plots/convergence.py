"""Error against step or tolerance, with triangles that show the slope of each documented order."""

from __future__ import annotations

from typing import Any

from cross_checks.records.record import Record
from reports.drawing.numbers import setting, short
from reports.drawing.plots.figure import Figure, add_series, lines, new_figure, to_data
from reports.drawing.plots.palette import styles
from reports.facts.cheapest import known_error, usable

STRAIGHT = 0.1  # of the scene; lines bend above it, where a mechanism's own size limits the error
AXES = {"step": "step h, s", "rtol": "relative tolerance asked"}


def convergence(records: list[Record], over: str, orders: dict[tuple[str, str], int]) -> dict[str, Any] | None:
    """Return the figure of the error over `over` (step in s, or rtol), or None without such records."""
    drawn = [r for r in records if usable(r) and r.settings.get(over) is not None]
    if not drawn:
        return None
    figure = new_figure(AXES[over], "error over the scene's scales")
    for (engine, method), style in styles(records).items():
        own = sorted((r for r in drawn if (r.engine, r.method) == (engine, method)), key=lambda r: r.settings[over])
        if own:
            x, y = [r.settings[over] for r in own], [r.error.value for r in own if r.error]
            text = [lines(f"{engine} · {method}", setting(r.settings), f"error {_error(r)}") for r in own]
            add_series(figure, engine, method, style, x, y, text=text, hovertemplate="%{text}<extra></extra>")
    if over == "step":
        for order in sorted({orders[r.engine, r.method] for r in drawn if (r.engine, r.method) in orders}):
            _slope_triangle(figure, [r for r in drawn if orders.get((r.engine, r.method)) == order], order)
    return to_data(figure)


def _error(record: Record) -> str:
    assert record.error is not None
    return f"{short(record.error.value)} of the scene"


def _slope_triangle(figure: Figure, records: list[Record], order: int) -> None:
    """Draw h^order over a factor of three in the step, just below the lowest line of methods of that order."""
    near = [r for r in records if known_error(r) < STRAIGHT]
    if not near:
        return
    x1 = max(r.settings["step"] for r in near)
    x0, y1 = x1 / 3.0, 0.3 * min(known_error(r) for r in near if r.settings["step"] == x1)
    y0 = y1 * (x0 / x1) ** order
    figure.add_scatter(
        x=[x0, x1, x1, x0],
        y=[y0, y0, y1, y0],
        mode="lines",
        line={"color": "#888888", "width": 1},
        fill="toself",
        fillcolor="rgba(128,128,128,0.12)",
        showlegend=False,
        hoverinfo="skip",
    )
    figure.add_scatter(
        x=[x1],
        y=[y0],
        mode="text",
        text=[f"order {order} "],
        textposition="bottom left",
        textfont={"color": "#888888", "size": 12},
        showlegend=False,
        hoverinfo="skip",
    )
