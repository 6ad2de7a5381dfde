"""Trust: are the runs' own error estimates honest? The table that `mbs-ref calibrate --table` left in the tree."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

from reports.facts.report_data import ReportData
from reports.page.section import Section

LEAD = (
    "Every run of mbs_ref estimates its own error. Random runs, of random mechanisms and of every scene, with random "
    "methods and tolerances, were held against far tighter ones."
)
FILE = "calibration.json"


@cache
def kept() -> dict[str, Any]:
    """Return the calibration that the tree holds: first seed, runs, and the rows of the table."""
    return json.loads((files("benchmarks") / FILE).read_text(encoding="utf-8"))


def context(data: ReportData) -> dict[str, Any]:
    return {"calibration": kept()}


SECTION = Section("trust", "Trust in the error estimates", LEAD, context, template="studies/trust.html")
