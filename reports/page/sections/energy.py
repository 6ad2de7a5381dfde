"""Energy drift over time."""

from __future__ import annotations

from typing import Any

from reports.drawing.plots.energy import energy
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.page.per_scene import per_scene

LEAD = "Energy that the integration created or lost, work of drives counted. Small drift alone does not prove accuracy."


def context(data: ReportData) -> dict[str, Any]:
    return {"plots": per_scene(data, energy)}


SECTION = Section("energy", "Energy drift", LEAD, context)
