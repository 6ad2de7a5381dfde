"""Axes, colours and marks of every plot: plain data that plotly.js reads, recoloured by pages for light and dark."""

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import cycle, product
from typing import Any
from zlib import crc32

from cross_checks import engines
from cross_checks.records.record import Record

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


def add_series(figure: Figure, engine: str, method: str, style: "Style", x: Values, y: Values, **more: Any) -> None:
    """Add one method's line with markers, grouped under its engine in the legend."""
    mode = more.pop("mode", "lines+markers")
    figure.add_scatter(
        x=x, y=[None if value is None else max(abs(value), FLOOR) for value in y], mode=mode, name=html.escape(method),
        meta={"engine": engine}, legendgroup=engine, legendgrouptitle={"text": html.escape(engine)},
        line={"color": style.colour, "dash": style.dash, "width": 2},
        marker={"symbol": style.symbol, "size": 8, "color": style.colour}, **more,
    )  # fmt: skip


def lines(*parts: str) -> str:
    """Return hover text of several lines with every part escaped."""
    return "<br>".join(html.escape(part) for part in parts)


def to_data(figure: Figure) -> dict[str, Any]:
    """Return the figure as plain data."""
    return {"data": figure.data, "layout": figure.layout}


# Okabe and Ito's colour-blind safe set, shifted to hold 3:1 contrast on white and on near-black alike, and five more
COLOURS = ("#2b7bd6", "#d97706", "#0f9d70", "#c0569b", "#8a6fd1", "#2a9fb5", "#a58a12", "#c8524a",
           "#75808c", "#e32bd6", "#9a6a4a", "#6a9a1c", "#5e55f0")  # fmt: skip
DASHES = ("solid", "dash", "dot", "dashdot", "longdash", "longdashdot")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross", "star", "hexagon", "triangle-down", "bowtie",
           "triangle-right", "hourglass", "triangle-left")  # fmt: skip


@dataclass(frozen=True)
class Style:
    """How a method of an engine is drawn: colour and symbol are the engine's, dash and filling are the method's."""

    colour: str
    symbol: str
    dash: str = DASHES[0]


@cache
def style_of(engine: str) -> Style:
    """Return an engine's style, by its place among the project's adapters; of another's engine by its name alone."""
    known = [name for name in engines.names() if engines.is_ours(name)]
    place = known.index(engine) if engine in known else len(known) + crc32(engine.encode())
    return Style(COLOURS[place % len(COLOURS)], SYMBOLS[place % len(SYMBOLS)])


def styles(records: Iterable[Record]) -> dict[tuple[str, str], Style]:
    """Return the style of each (engine, method) met in the records, the reference solver first."""
    first = engines.names()[0]
    listed = sorted({(r.engine, r.method) for r in records}, key=lambda pair: (pair[0] != first, pair))
    fillings = {engine: cycle(product(("", "-open"), DASHES)) for engine, _ in listed}

    def style(engine: str) -> Style:
        own, (filling, dash) = style_of(engine), next(fillings[engine])
        return Style(own.colour, own.symbol + filling, dash)

    return {pair: style(pair[0]) for pair in listed}
