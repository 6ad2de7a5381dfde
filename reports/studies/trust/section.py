"""Trust: are error estimates honest, symmetries kept, bits repeated? Tables that commands left in the tree."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

from reports.facts.report_data import ReportData, Section

LEAD = (
    "Every run of mbs_ref estimates its own error. Random runs, of random mechanisms and of every scene, with random "
    "methods and tolerances, were held against far tighter ones. Of the engines in the tables it was asked whether a "
    "scene that is turned, rescaled or renamed moves as its image, and whether a run gives the same bits again."
)
TABLES = ("calibration", "symmetry", "repeatability")


@cache
def kept(table: str) -> dict[str, Any]:
    """Return what `mbs-ref calibrate`, `symmetry` or `repeatability` wrote with --table."""
    return json.loads((files("benchmarks") / f"{table}.json").read_text(encoding="utf-8"))


def context(data: ReportData) -> dict[str, Any]:
    return {table: kept(table) for table in TABLES}


SECTION = Section("trust", "Trust: estimates, symmetry, repeatability", LEAD, context)
