"""Performance profiles over all scenes, at three accuracies, each with its table."""

from __future__ import annotations

from typing import Any

from benchmarks.profiles import ERRORS, Profile, profiles
from reports.page.numbers import ABSENT, metres, short
from reports.page.plots.palette import styles
from reports.page.plots.profiles import profile_plot
from reports.page.report_data import ReportData
from reports.page.section import Section

LEAD = (
    "Over all scenes at once: how often a method is the cheapest (at the left edge), how often it comes within a "
    "factor of the cheapest, and how many scenes it solves at all (at the right edge). A scene it cannot model counts "
    "as missed."
)
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
    style = styles(data.records, data.engines)
    blocks = []
    for error in ERRORS:
        found = profiles(data.records, error)
        missed = [f"{p.solver[0]} {p.solver[1]}" for p in found if not p.factors]
        rows = [row(profile) for profile in found if profile.factors]
        problems = found[0].problems if found else 0
        plot = profile_plot(found, style)
        blocks.append({"error": metres(error), "plot": plot, "rows": rows, "problems": problems, "missed": missed})
    return {"blocks": blocks}


SECTION = Section("profiles", "Performance profiles", LEAD, context)
