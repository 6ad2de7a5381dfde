"""Performance profiles of the engines over all scenes, at three accuracies, each with its table."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from benchmarks.profiles import ERRORS, Profile, profiles
from reports.drawing.numbers import ABSENT, short
from reports.drawing.plots.palette import styles
from reports.drawing.plots.profiles import profile_plot
from reports.drawing.section import Section
from reports.facts.report_data import OURS, ReportData
from reports.facts.timing import is_timed

LEAD = (
    "Over all scenes at once, each engine at its cheapest setting: how often it is the cheapest (left edge), how often "
    "it comes within a factor of the cheapest, and how many scenes it solves at all (right edge). A scene "
    "it cannot model counts as missed. Our own solver takes no part in the ranking."
)
BEST = "cheapest setting"
FACTORS = (1.0, 2.0, 10.0)  # times the best


def row(profile: Profile) -> dict[str, Any]:
    """Return a method's line of the table."""
    engine, method = profile.solver
    middle = profile.factors[len(profile.factors) // 2] if profile.factors else None
    return {
        "engine": engine,
        "method": method,
        "shares": [f"{profile.share(factor):.0%}" for factor in FACTORS],
        "solved": f"{len(profile.factors)} of {profile.problems}",
        "median": ABSENT if middle is None else f"{short(middle)} ×",
    }


def context(data: ReportData) -> dict[str, Any]:
    records = [replace(r, method=BEST) for r in data.records if is_timed(r) and r.engine != OURS]
    style = styles(records, [name for name in data.engines if name != OURS])
    blocks = []
    for error in ERRORS:
        found = profiles(records, error)
        missed = [p.solver[0] for p in found if not p.factors]
        rows = [row(profile) for profile in found if profile.factors]
        problems = found[0].problems if found else 0
        plot = profile_plot(found, style)
        blocks.append({"error": short(error), "plot": plot, "rows": rows, "problems": problems, "missed": missed})
    return {"blocks": blocks}


SECTION = Section("profiles", "Performance profiles", LEAD, context)
