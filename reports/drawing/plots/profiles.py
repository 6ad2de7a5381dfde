"""Performance profiles: the share of problems that an engine solves within a factor of the best."""

from __future__ import annotations

from typing import Any

from reports.drawing.plots.figure import add_series, lines, new_figure, to_data
from reports.drawing.plots.palette import style_of
from reports.facts.standings import Standing

BEYOND = 2.0  # times the largest factor: where the axis ends
MOST = 1e4  # times the best: nobody waits longer
BEST = "cheapest setting"  # the name of an engine's one line


def profile_plot(ranked: list[Standing]) -> dict[str, Any] | None:
    """Return the figure of rho(tau): factor of the best time across, share of problems up; None without any."""
    if not ranked:
        return None
    end = min(MOST, BEYOND * max(max(standing.factors.values()) for standing in ranked))
    figure = new_figure("times the best loop time, tau", "share of the problems solved, rho", y_log=False)
    for standing in ranked:
        inner = [factor for factor in sorted(standing.factors.values()) if factor < end]
        x = [1.0, *inner, end]
        y = [standing.share(factor) for factor in x]
        text = [lines(standing.engine, f"{share:.0%} within {factor:.3g} times the best") for factor, share in
                zip(x, y, strict=True)]  # fmt: skip
        add_series(figure, standing.engine, BEST, style_of(standing.engine), x, y, mode="lines", text=text,
                   hovertemplate="%{text}<extra></extra>")  # fmt: skip
        figure.data[-1]["line"] |= {"shape": "hv"}
    figure.update_yaxes(range=[0.0, 1.05], tickformat=".0%")
    return to_data(figure)
