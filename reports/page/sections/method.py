"""How this report judges and times, the truths that it measures errors from, and the machine it ran on."""

import re
from inspect import getsource
from typing import Any

from cross_checks.judge import bounds, search
from cross_checks.judge.convergence import calibration, model
from cross_checks.judge.vocabulary import MEANINGS
from cross_checks.prices import timing
from cross_checks.records.record import BUSY, is_busy, is_timed
from reports.facts.report_data import INSIDE, ReportData, Section

CONSTANT = re.compile(r"^([A-Z_]+) = (.+?)  # (.+)$", re.MULTILINE)  # name, value and meaning


def context(data: ReportData) -> dict[str, Any]:
    ranked = [record for record in data.records if is_timed(record)]
    return {
        "meanings": MEANINGS, "model": str(model.__doc__),
        "constants": [(name.lower().replace("_", " "), *rest) for name, *rest in CONSTANT.findall(getsource(bounds))],
        "calibration": calibration(), "search": str(search.__doc__), "rule": str(timing.__doc__),
        "inside": {name: INSIDE[name] for name in data.engines if name in INSIDE}, "ranked": len(ranked),
        "busy": sum(is_busy(record) for record in ranked), "busy_share": f"{BUSY:.0%}", "most_steps": bounds.MOST_STEPS,
        "longest": f"{bounds.LONGEST:g}",
    }  # fmt: skip


SECTION = Section("method", "How it is judged and timed", context)
ENVIRONMENT = Section("environment", "Environment", lambda data: {"environment": data.environment})
TRUTHS = Section("truths", "Truths", lambda data: {"rows": data.truths})
