"""Convergence order: error against step, and against tolerance."""

from __future__ import annotations

from functools import partial
from typing import Any

from reports.drawing.plots.convergence import convergence
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.page.per_scene import per_scene

LEAD = (
    "A method of order p gains a factor 2^p when its step is halved: its line runs parallel to that order's triangle. "
    "A line that goes flat has met its limit: roundoff, or a wrong answer."
)


def context(data: ReportData) -> dict[str, Any]:
    orders = {(c.engine, c.method): c.documented_order for c in data.cells if c.documented_order}
    by_step = partial(convergence, over="step", orders=orders)
    by_tolerance = partial(convergence, over="rtol", orders=orders)
    return {"by_step": per_scene(data, by_step), "by_tolerance": per_scene(data, by_tolerance)}


SECTION = Section("convergence", "Convergence order", LEAD, context)
