"""How this report judges and times."""

from __future__ import annotations

from typing import Any

from benchmarks import loop_times
from benchmarks.loop_times import is_busy, is_timed
from benchmarks.timing import BUSY
from cross_checks.judge import search
from cross_checks.judge.bounds import MOST_STEPS
from cross_checks.judge.convergence import model
from cross_checks.judge.convergence.calibration import calibration
from cross_checks.judge.verdict import CALIBRATED, CONFIRMED, DOUBTFUL, FAILING, FALLING, NEAR_BEST, RESOLVED, ROUNDED
from cross_checks.judge.vocabulary import AGREEMENT, MEANINGS
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.facts.timed_loop import INSIDE

LEAD = "How a verdict follows from the runs of a method, how often verdicts are right, and what a time holds."
CONSTANTS = {
    "agreement": (AGREEMENT, "of the scene: an error at or below this is agreement"),
    "failing": (FAILING, "odds of a failure from which a method is classified as wrong"),
    "doubtful": (DOUBTFUL, "odds of a failure up to which a method agrees or converges"),
    "resolved": (RESOLVED, "of the scene: a larger error shows no approach"),
    "confirmed": (CONFIRMED, "levels of runs at least that classify a method as wrong"),
    "falling": (FALLING, "times the errors of the two levels before: a smaller error is no failure"),
    "near best": (NEAR_BEST, "times the best error: a finest run that is farther off shows no approach"),
    "rounded": (ROUNDED, "times what rounding may add: a smaller error says nothing of the method"),
    "calibrated": (CALIBRATED, "the smallest odds that are stated"),
}


def context(data: ReportData) -> dict[str, Any]:
    ranked = [record for record in data.records if is_timed(record)]
    return {
        "meanings": MEANINGS,
        "model": str(model.__doc__),
        "constants": CONSTANTS,
        "calibration": calibration(),
        "search": str(search.__doc__),
        "rule": str(loop_times.__doc__),
        "inside": {name: INSIDE[name] for name in data.engines if name in INSIDE},
        "ranked": len(ranked),
        "busy": sum(is_busy(record) for record in ranked),
        "busy_share": f"{BUSY:.0%}",
        "most_steps": MOST_STEPS,
    }


SECTION = Section("method", "How it is judged and timed", LEAD, context)
