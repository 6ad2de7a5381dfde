"""Where this report was made."""

from __future__ import annotations

from typing import Any

from reports.drawing.section import Section
from reports.facts.report_data import ReportData

LEAD = "Times compare only within one machine and one report; versions are those of the installed packages."


def context(data: ReportData) -> dict[str, Any]:
    return {"environment": data.environment}


SECTION = Section("environment", "Environment", LEAD, context)
