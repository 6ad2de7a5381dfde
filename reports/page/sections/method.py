"""How this report judges and times."""

from __future__ import annotations

from typing import Any

from benchmarks import loop_times
from benchmarks.loop_times import is_busy, is_timed
from benchmarks.timing import BUSY
from cross_checks.judge import search, verdict
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.facts.timed_loop import INSIDE

LEAD = "The criteria of every verdict, as the judge's own source states them, and what a time holds."


def context(data: ReportData) -> dict[str, Any]:
    ranked = [record for record in data.records if is_timed(record)]
    return {
        "criteria": str(verdict.__doc__),
        "search": str(search.__doc__),
        "rule": str(loop_times.__doc__),
        "inside": {name: INSIDE[name] for name in data.engines if name in INSIDE},
        "ranked": len(ranked),
        "busy": sum(is_busy(record) for record in ranked),
        "busy_share": f"{BUSY:.0%}",
        "most_steps": search.MOST_STEPS,
    }


SECTION = Section("method", "How it is judged and timed", LEAD, context)
