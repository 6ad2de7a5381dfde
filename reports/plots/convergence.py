"""Error against step or tolerance, with triangles that show the slope of each documented order."""

from __future__ import annotations

from typing import Any

from cross_checks.record import Record
from reports.page.cheapest import known_error, usable
from reports.page.numbers import metres, setting
from reports.plots.figure import add_series, lines, new_figure, to_data
from reports.plots.palette import Style

AXES = {"step": "step h, s", "rtol": "relative tolerance asked"}


def convergence(
    records: list[Record], styles: dict[tuple[str, str], Style], over: str, orders: dict[tuple[str, str], int]
) -> dict[str, Any] | None:
    """Return the figure of error (m) over `over` (step in s, or rtol), or None without such records."""
    drawn = [r for r in records if usable(r) and r.settings.get(over) is not None]
    if not drawn:
        return None
    figure = new_figure(AXES[over], "largest position error, m")
    for (engine, method), style in styles.items():
        own = sorted((r for r in drawn if (r.engine, r.method) == (engine, method)), key=lambda r: r.settings[over])
        if own:
            x, y = [r.settings[over] for r in own], [r.error.value for r in own if r.error]
            text = [lines(f"{engine} · {method}", setting(r.settings), f"error {_error(r)}") for r in own]
            add_series(figure, engine, method, style, x, y, text=text, hovertemplate="%{text}<extra></extra>")
    if over == "step":
        met = {(r.engine, r.method) for r in drawn}
        for order in sorted({orders[key] for key in met if key in orders}):
            _slope_triangle(figure, drawn, order)
    return to_data(figure)


def _error(record: Record) -> str:
    assert record.error is not None
    return metres(record.error.value)


def _slope_triangle(figure, records: list[Record], order: int) -> None:
    """Draw h^order over a factor of four in the step, at the lower right where curves leave room."""
    x1 = max(r.settings["step"] for r in records) * 1.6
    x0 = x1 / 4.0
    top = max(known_error(r) for r in records if known_error(r) < 1.0) if _any_small(records) else 1.0
    y1 = top * 10.0 ** (-1.5 * order)
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
        x=[x0],
        y=[y0],
        mode="text",
        text=[f"order {order} "],
        textposition="middle left",
        textfont={"color": "#888888", "size": 12},
        showlegend=False,
        hoverinfo="skip",
    )


def _any_small(records: list[Record]) -> bool:
    return any(known_error(r) < 1.0 for r in records)
