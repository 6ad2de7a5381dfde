"""A figure for each scene whose runs hold the data: convergence, compliance and error, energy, and time split."""

import html
from collections.abc import Callable
from functools import partial
from typing import Any

from cross_checks.records import plots as of_runs
from cross_checks.records.numbers import duration, setting, short
from cross_checks.records.plots import Figure, add_series, lines, new_figure, styles, to_data
from cross_checks.records.record import Record, best_of_engines, known_error, usable
from reports.facts.report_data import ReportData, Section


def _per_scene(data: ReportData, plot: Callable[..., dict[str, Any] | None]) -> dict[str, dict[str, Any]]:
    """Return scene -> figure for every scene that `plot` can draw."""
    figures = {scene: plot(data.of_scene(scene)) for scene in data.scenes}
    return {scene: figure for scene, figure in figures.items() if figure}


def _convergence(data: ReportData) -> dict[str, Any]:
    orders = {(c.engine, c.method): c.documented_order for c in data.cells if c.documented_order}
    plots = {key: partial(convergence, over=over, orders=orders)
             for key, over in (("by_step", "step"), ("by_tolerance", "rtol"))}  # fmt: skip
    return {key: _per_scene(data, plot) for key, plot in plots.items()}


SECTIONS = (
    Section("compliance", "Compliance over time",
            lambda data: {"compliance": _per_scene(data, of_runs.compliance),
                          "error": _per_scene(data, of_runs.error_history)}),
    Section("energy", "Energy drift", lambda data: {"plots": _per_scene(data, of_runs.energy)}),
    Section("convergence", "Convergence order", _convergence),
    Section("time_split", "Time split", lambda data: {"plots": _per_scene(data, time_split)}),
)  # fmt: skip


STRAIGHT = 0.1  # of the scene; lines bend above it, where a mechanism's own size limits the error
GREY = "#888888"
AXES = {"step": "step h, s", "rtol": "relative tolerance"}


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
            label, errors = f"{engine} · {method}", [f"error {short(value)} of the scene" for value in y]
            text = [lines(label, setting(r.settings), error) for r, error in zip(own, errors, strict=True)]
            add_series(figure, engine, method, style, x, y, text=text, hovertemplate="%{text}<extra></extra>")
    if over == "step":
        for order in sorted({orders[r.engine, r.method] for r in drawn if (r.engine, r.method) in orders}):
            _slope_triangle(figure, [r for r in drawn if orders.get((r.engine, r.method)) == order], order)
    return to_data(figure)


def _slope_triangle(figure: Figure, records: list[Record], order: int) -> None:
    """Draw h^order over a factor of three in the step, just below the lowest line of methods of that order."""
    near = [r for r in records if known_error(r) < STRAIGHT]
    if not near:
        return
    x1 = max(r.settings["step"] for r in near)
    x0, y1 = x1 / 3.0, 0.3 * min(known_error(r) for r in near if r.settings["step"] == x1)
    y0 = y1 * (x0 / x1) ** order
    quiet = {"showlegend": False, "hoverinfo": "skip"}
    filled = {"fill": "toself", "fillcolor": "rgba(128,128,128,0.12)", "line": {"color": GREY, "width": 1}}
    figure.add_scatter(x=[x0, x1, x1, x0], y=[y0, y0, y1, y0], mode="lines", **filled, **quiet)
    text = {"text": [f"order {order} "], "textposition": "bottom left", "textfont": {"color": GREY, "size": 12}}
    figure.add_scatter(x=[x1], y=[y0], mode="text", **text, **quiet)


PHASES = {
    "build_s": ("build the model", "#9aa7b5"),
    "first_call_s": ("first call (compile, allocate)", "#c9a227"),
    "loop_s": ("integration loop", "#2b7bd6"),
}


def time_split(records: list[Record]) -> dict[str, Any] | None:
    """Return the bars of each method's phases (ms), or None when nothing finished."""
    drawn = [r for r in best_of_engines(records) if usable(r)]
    if not drawn:
        return None
    drawn.sort(key=lambda r: r.times["loop_s"], reverse=True)
    figure = new_figure("time, ms", "", x_log=False, y_log=False)
    names = [html.escape(f"{r.engine} · {r.method}") for r in drawn]
    for key, (phase, colour) in PHASES.items():
        spans = [r.times.get(key, 0.0) for r in drawn]
        text = [
            lines(f"{r.engine} · {r.method}", setting(r.settings), f"{phase}: {duration(s)}")
            for r, s in zip(drawn, spans, strict=True)
        ]
        x = [s * 1e3 if s > 0.0 else None for s in spans]
        figure.add("bar", x=x, y=names, orientation="h", name=phase, marker={"color": colour}, text=text,
                   textposition="none", hovertemplate="%{text}<extra></extra>")  # fmt: skip
    figure.update_yaxes(type="category")
    figure.layout |= {"barmode": "group", "bargap": 0.25, "height": 120 + 42 * len(drawn)}
    figure.layout["legend"] |= {"orientation": "h", "y": 1.02, "yanchor": "bottom", "traceorder": "normal"}
    return to_data(figure)
