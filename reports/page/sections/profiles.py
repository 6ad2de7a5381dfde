"""Performance profiles of the engines over all scenes, at three accuracies, each with its table."""

from __future__ import annotations

from typing import Any

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import OURS
from reports.drawing.numbers import short
from reports.drawing.plots.profiles import profile_plot
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.facts.standings import Standing, standings

LEAD = (
    "Over all scenes at once, each engine at its cheapest setting: how often it is the cheapest (left edge), how often "
    "it comes within a factor of the cheapest, and how many scenes it solves at all (right edge). A scene "
    "it cannot model counts as missed. Our own solver takes no part in the ranking."
)
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
    return {"blocks": [_block(data, target) for target in TARGETS]}


SECTION = Section("profiles", "Performance profiles", LEAD, context)
