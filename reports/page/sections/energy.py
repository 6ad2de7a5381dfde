"""Energy drift over time."""

from __future__ import annotations

from typing import Any

from reports.page.report_data import ReportData
from reports.page.section import Section
from reports.page.per_scene import per_scene
from reports.plots.energy import energy

LEAD = "Energy that the integration created or lost, after the work of loads and drives. Small drift alone is no proof of accuracy."


def context(data: ReportData) -> dict[str, Any]:
    return {"plots": per_scene(data, energy)}


SECTION = Section("energy", "Energy drift", LEAD, 60, context, plots=True)
