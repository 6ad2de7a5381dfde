"""Space: what Euler parameters do and cost, measured."""

from __future__ import annotations

from typing import Any

from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.studies.space.facts import SpaceFacts

LEAD = "Spatial bodies carry four Euler parameters of norm one: what that does, and what it costs."


def context(data: ReportData) -> dict[str, Any]:
    return {"space": data.study(SpaceFacts)}


SECTION = Section("space", "Space", LEAD, context)
