"""Performance profiles of the engines over all scenes, at three accuracies, each with its table."""

from typing import Any

from cross_checks.judge.vocabulary import OURS
from cross_checks.records.numbers import short
from cross_checks.records.plots import add_series, lines, new_figure, style_of, to_data
from reports.facts.report_data import ReportData, Section, Standing, standings

FACTORS = (1.0, 2.0, 10.0)  # times the best


def row(standing: Standing) -> dict[str, Any]:
    """Return an engine's line of the table."""
    return {
        "engine": standing.engine,
        "shares": [f"{standing.share(factor):.0%}" for factor in FACTORS],
        "solved": f"{len(standing.factors)} of {standing.problems}",
        "median": f"{short(standing.median)} ×",
    }


def _block(data: ReportData, target: float) -> dict[str, Any]:
    ranked = [standing for standing in standings(data, target) if standing.engine != OURS]
    met, ran = {one.engine for one in ranked}, {record.engine for record in data.records if record.engine != OURS}
    return {
        "error": short(target), "plot": profile_plot(ranked), "rows": [row(standing) for standing in ranked],
        "problems": ranked[0].problems if ranked else 0,
        "missed": [name for name in data.engines if name in ran - met],
    }  # fmt: skip


def context(data: ReportData) -> dict[str, Any]:
    return {"blocks": [_block(data, target) for target in data.targets]}


SECTION = Section("profiles", "Performance profiles", context)


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
