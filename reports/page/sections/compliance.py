"""Constraint compliance and error over time."""

from __future__ import annotations

from typing import Any

from reports.drawing.plots.compliance import compliance
from reports.drawing.plots.error_history import error_history
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.page.per_scene import per_scene

LEAD = (
    "How far the joints gape while the mechanism moves, measured by one code from every engine's poses; and beside it "
    "the distance from the truth, because closed joints do not prove a right answer."
)


def context(data: ReportData) -> dict[str, Any]:
    return {"compliance": per_scene(data, compliance), "error": per_scene(data, error_history)}


SECTION = Section("compliance", "Compliance over time", LEAD, context)
