"""What every plot shares: quiet axes that the page recolours for light and dark, and safe hover text."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from reports.drawing.plots.palette import Style

FLOOR = 1e-17  # a quantity that is exactly zero is drawn here on a logarithmic axis


@dataclass
class Figure:
    """A figure as plotly.js reads it. Plotly's own Python objects check every property, at 20 times the time: a test
    lets them."""

    layout: dict[str, Any]
    data: list[dict[str, Any]] = field(default_factory=list)

    def add(self, kind: str, **trace: Any) -> None:
        """Add a trace of a kind: scatter or bar."""
        self.data.append({"type": kind, **trace})

    def add_scatter(self, **trace: Any) -> None:
        """Add lines, markers or text."""
        self.add("scatter", **trace)

    def update_yaxes(self, **axis: Any) -> None:
        """Change the vertical axis."""
        self.layout["yaxis"] |= axis

    def to_html(self, full_html: bool = True, include_plotlyjs: bool = True) -> str:
        """Return a page, or a part of one, with the figure alone; ValueError where a property is not plotly's."""
        from plotly.io import to_html

        return to_html(to_data(self), full_html=full_html, include_plotlyjs=include_plotlyjs)


def new_figure(x_title: str, y_title: str, x_log: bool = True, y_log: bool = True, height: int = 540) -> Figure:
    """Return an empty figure, `height` pixels high, with titled axes (units in the titles)."""
    return Figure({
        "height": height,
        "margin": {"l": 76, "r": 16, "t": 40, "b": 56},
        "hovermode": "closest",
        "legend": {"groupclick": "toggleitem", "font": {"size": 12}, "tracegroupgap": 6},
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "#8a94a0", "activecolor": "#2b7bd6"},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "xaxis": _axis(x_title, x_log),
        "yaxis": _axis(y_title, y_log),
    })  # fmt: skip


def _axis(title: str, log: bool) -> dict[str, Any]:
    shown = {"title": {"text": title, "standoff": 10}, "zeroline": False, "automargin": True}
    return shown | ({"type": "log", "exponentformat": "power", "dtick": 1} if log else {"type": "-"})


type Values = Sequence[float | None]  # None is a gap


def add_series(figure: Figure, engine: str, method: str, style: Style, x: Values, y: Values, **more: Any) -> None:
    """Add one method's line with markers, grouped under its engine in the legend."""
    mode = more.pop("mode", "lines+markers")
    figure.add_scatter(
        x=x,
        y=[None if value is None else max(abs(value), FLOOR) for value in y],
        mode=mode,
        name=html.escape(method),
        meta={"engine": engine},
        legendgroup=engine,
        legendgrouptitle={"text": html.escape(engine)},
        line={"color": style.colour, "dash": style.dash, "width": 2},
        marker={"symbol": style.symbol, "size": 8, "color": style.colour},
        **more,
    )


def lines(*parts: str) -> str:
    """Return hover text of several lines with every part escaped."""
    return "<br>".join(html.escape(part) for part in parts)


def to_data(figure: Figure) -> dict[str, Any]:
    """Return the figure as plain data."""
    return {"data": figure.data, "layout": figure.layout}
