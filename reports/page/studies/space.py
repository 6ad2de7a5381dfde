"""Space: what Euler parameters do and cost, measured."""

from __future__ import annotations

from typing import Any

from reports.facts.report_data import ReportData
from reports.page.section import Section

LEAD = "Spatial bodies carry four Euler parameters of norm one: what that does, and what it costs."


def context(data: ReportData) -> dict[str, Any]:
    return {"space": data.space}


SECTION = Section("space", "Space", LEAD, context, template="studies/space.html")
