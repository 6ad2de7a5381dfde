"""Plots of runs: axes, colours and marks, error against loop time, and error, energy and compliance over time.

They are plain data that plotly.js reads, recoloured by pages for light and dark.
"""

import html
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from itertools import cycle, product
from typing import Any
from zlib import crc32

from cross_checks import engines
from cross_checks.records.numbers import closure, duration, metres, setting, short
from cross_checks.records.record import Record, best_of_engines, floor, is_timed, loop_time, usable

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


compliance = partial(_history, key="compliance_position", title="largest |C(q, t)|, m or rad")
energy = partial(_history, key="energy_drift", title="|energy − initial − work|, J")
error_history = partial(_history, key="error", title="error over the scene's scales")

FRONTIER = "frontier"  # the name of an engine's one line


def work_precision(records: list[Record]) -> dict[str, Any]:
    """Return the figure of one scene: time of the loop (ms) across, error over the scene's scales up."""
    figure = new_figure("time of the integration loop, ms", "error over the scene's scales")
    chosen = styles(records)
    for engine in dict.fromkeys(engine for engine, _ in chosen):
        if own := frontier([r for r in records if r.engine == engine]):
            _add(figure, engine, FRONTIER, style_of(engine), own)
            figure.data[-1]["marker"] |= {"size": 9}
            figure.data[-1]["line"] |= {"width": 2.5}
    for (engine, method), style in chosen.items():
        own = sorted((r for r in records if (r.engine, r.method) == (engine, method) and usable(r)), key=loop_time)
        if own:
            _add(figure, engine, method, style, own, visible="legendonly")
            figure.data[-1]["meta"] |= {"detail": True}
            figure.data[-1]["line"] |= {"width": 1.2}
    _truth_band(figure, records)
    return to_data(figure)


def frontier(records: list[Record]) -> list[Record]:
    """Return the runs that no other beats both in time and in error, the cheapest first."""
    result: list[Record] = []
    for record in sorted(filter(usable, records), key=loop_time):
        assert record.error is not None
        if not result or record.error.value < result[-1].error.value:  # type: ignore[union-attr]
            result.append(record)
    return result


def _add(figure: Figure, engine: str, method: str, style: Style, records: list[Record], **more: Any) -> None:
    x = [loop_time(r) * 1e3 for r in records]
    y = [r.error.value for r in records if r.error]
    text = [_hover(r) for r in records]
    add_series(figure, engine, method, style, x, y, text=text, hovertemplate="%{text}<extra></extra>", **more)


def _hover(record: Record) -> str:
    assert record.error is not None
    how = "with a processor to itself" if is_timed(record) else "one run, beside others"
    return lines(
        f"{record.engine} · {record.method}",
        setting(record.settings),
        f"error {short(record.error.value)}, {metres(record.error.metres)}; worst: {record.error.worst}",
        f"joints within {closure(record.measure('compliance_position'))}",
        f"loop {duration(record.times['loop_s'])} ({how}), {record.steps} steps, {record.rhs_calls} right-hand sides",
    )


def _truth_band(figure: Figure, records: list[Record]) -> None:
    """Shade the errors that the truth cannot judge, and frame the axis to show it."""
    known = floor(records)
    drawn = [max(r.error.value, FLOOR) for r in records if usable(r) and r.error]
    if known <= 0.0 or not drawn:
        return
    low, high = min(known / 10.0, min(drawn) / 3.0), max(drawn) * 3.0
    grey = {"fillcolor": "rgba(128,128,128,0.18)", "line": {"width": 0}, "layer": "below"}
    figure.layout["shapes"] = [
        {"type": "rect", "xref": "paper", "x0": 0, "x1": 1, "y0": low * 1e-3, "y1": known, **grey}
    ]
    figure.layout["annotations"] = [
        {"text": f"errors below {short(known)} cannot be resolved", "xref": "paper", "x": 0.01, "y": math.log10(known),
         "yanchor": "top", "xanchor": "left", "showarrow": False, "font": {"size": 12}}
    ]  # fmt: skip
    figure.update_yaxes(range=[math.log10(low), math.log10(high)])
