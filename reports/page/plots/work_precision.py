"""Error against loop time: what accuracy costs, method by method."""

from __future__ import annotations

import math
from typing import Any

from cross_checks.records.record import Record
from reports.page.cheapest import floor, usable
from reports.page.numbers import duration, metres, setting
from reports.page.plots.figure import FLOOR, add_series, lines, new_figure, to_data
from reports.page.plots.palette import Style


def work_precision(records: list[Record], styles: dict[tuple[str, str], Style]) -> dict[str, Any]:
    """Return the figure of one scene: time of the loop (ms) across, largest position error (m) up."""
    figure = new_figure("time of the integration loop, ms", "largest position error, m")
    for (engine, method), style in styles.items():
        own = [r for r in records if (r.engine, r.method) == (engine, method) and usable(r)]
        own.sort(key=lambda r: r.times["loop_s"])
        if own:
            x = [r.times["loop_s"] * 1e3 for r in own]
            y = [r.error.value for r in own if r.error]
            text = [_hover(r) for r in own]
            add_series(figure, engine, method, style, x, y, text=text, hovertemplate="%{text}<extra></extra>")
    _truth_band(figure, records)
    return to_data(figure)


def _hover(record: Record) -> str:
    assert record.error is not None
    return lines(
        f"{record.engine} · {record.method}",
        setting(record.settings),
        f"error {metres(record.error.value)}, compliance {metres(record.compliance.get('position'))}",
        f"loop {duration(record.times['loop_s'])}, {record.steps} steps, {record.rhs_calls} right-hand sides",
    )


def _truth_band(figure, records: list[Record]) -> None:
    """Shade the errors that the truth cannot judge, and frame the axis to show it."""
    known = floor(records)
    drawn = [max(r.error.value, FLOOR) for r in records if usable(r) and r.error]
    if known <= 0.0 or not drawn:
        return
    low, high = min(known / 10.0, min(drawn) / 3.0), max(drawn) * 3.0
    figure.add_shape(type="rect", xref="paper", x0=0, x1=1, y0=low * 1e-3, y1=known,
                     fillcolor="rgba(128,128,128,0.18)", line_width=0, layer="below")  # fmt: skip
    figure.add_annotation(text=f"the truth judges no error below {metres(known)}", xref="paper", x=0.01,
                          y=math.log10(known), yanchor="top", xanchor="left", showarrow=False,
                          font={"size": 12})  # fmt: skip
    figure.update_yaxes(range=[math.log10(low), math.log10(high)])
