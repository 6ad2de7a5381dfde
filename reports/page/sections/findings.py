"""What the data say in words."""

from __future__ import annotations

from typing import Any

from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.page.findings import findings

LEAD = "What a reader should take away, worded from the data of this very report."


def context(data: ReportData) -> dict[str, Any]:
    return {"findings": findings(data)}


SECTION = Section("findings", "Findings", LEAD, context)
