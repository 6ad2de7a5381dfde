"""Where the time goes."""

from __future__ import annotations

from typing import Any

from reports.drawing.plots.time_split import time_split
from reports.drawing.section import Section
from reports.facts.report_data import ReportData

LEAD = (
    "Building the model, the first call and the loop apart, at each engine's cheapest setting within 1e-6 of the scene."
)


def context(data: ReportData) -> dict[str, Any]:
    figures = {scene: time_split(data.of_scene(scene)) for scene in data.scenes}
    return {"plots": {scene: figure for scene, figure in figures.items() if figure}}


SECTION = Section("time_split", "Time split", LEAD, context)
