"""Where the time goes: building the model, the first call, the loop."""

from __future__ import annotations

import html
from typing import Any

from cross_checks.records.record import Record
from reports.drawing.numbers import duration, setting
from reports.drawing.plots.figure import lines, new_figure, to_data
from reports.facts.cheapest import best_of_engines, usable

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
