"""Plots of the runs of one scene: error against loop time, and error, energy drift and compliance over time."""

import math
from typing import Any

from cross_checks.records.numbers import closure, duration, metres, setting, short
from cross_checks.records.plots import plot
from cross_checks.records.plots.plot import Figure
from cross_checks.records.record import Record, best_of_engines, floor, is_timed, loop_time, usable


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
    chosen = plot.styles(records)
    drawn.sort(key=lambda r: list(chosen).index((r.engine, r.method)))
    figure = plot.new_figure("time, s", title, x_log=False)
    figure.update_yaxes(dtick=None, nticks=10)
    for record in drawn:
        label = plot.lines(f"{record.engine} · {record.method}", setting(record.settings))
        hover = f"{label}<br>%{{y:.2e}} at %{{x:.3g}} s<extra></extra>"
        style = chosen[record.engine, record.method]
        # the first sample is zero by construction and would stretch the axis
        x, y = record.history["t"][1:], record.history[key][1:]
        plot.add_series(figure, record.engine, record.method, style, x, y, mode="lines", hovertemplate=hover)
    return plot.to_data(figure)


FRONTIER = "frontier"  # the name of an engine's one line


def work_precision(records: list[Record]) -> dict[str, Any]:
    """Return the figure of one scene: time of the loop (ms) across, error over the scene's scales up."""
    figure = plot.new_figure("time of the integration loop, ms", "error over the scene's scales")
    chosen = plot.styles(records)
    for engine in dict.fromkeys(engine for engine, _ in chosen):
        own = frontier([r for r in records if r.engine == engine])
        if own:
            _add(figure, engine, FRONTIER, plot.style_of(engine), own)
            figure.data[-1]["marker"] |= {"size": 9}
            figure.data[-1]["line"] |= {"width": 2.5}
    for (engine, method), style in chosen.items():
        own = sorted((r for r in records if (r.engine, r.method) == (engine, method) and usable(r)), key=loop_time)
        if own:
            _add(figure, engine, method, style, own, visible="legendonly")
            figure.data[-1]["meta"] |= {"detail": True}
            figure.data[-1]["line"] |= {"width": 1.2}
    _truth_band(figure, records)
    return plot.to_data(figure)


def frontier(records: list[Record]) -> list[Record]:
    """Return the runs that no other beats both in time and in error, the cheapest first."""
    result: list[Record] = []
    for record in sorted(filter(usable, records), key=loop_time):
        assert record.error is not None
        if not result or record.error.value < result[-1].error.value:  # type: ignore[union-attr]
            result.append(record)
    return result


def _add(figure: Figure, engine: str, method: str, style: plot.Style, records: list[Record], **more: Any) -> None:
    x = [loop_time(r) * 1e3 for r in records]
    y = [r.error.value for r in records if r.error]
    text = [_hover(r) for r in records]
    plot.add_series(figure, engine, method, style, x, y, text=text, hovertemplate="%{text}<extra></extra>", **more)


def _hover(record: Record) -> str:
    assert record.error is not None
    how = "with a processor to itself" if is_timed(record) else "one run, beside others"
    return plot.lines(
        f"{record.engine} · {record.method}",
        setting(record.settings),
        f"error {short(record.error.value)}, {metres(record.error.metres)}; worst: {record.error.worst}",
        f"joints within {closure(record.measure('compliance_position'))}",
        f"loop {duration(record.times['loop_s'])} ({how}), {record.steps} steps, {record.rhs_calls} right-hand sides",
    )


def _truth_band(figure: Figure, records: list[Record]) -> None:
    """Shade the errors that the truth cannot judge, and frame the axis to show it."""
    known = floor(records)
    drawn = [max(r.error.value, plot.FLOOR) for r in records if usable(r) and r.error]
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
