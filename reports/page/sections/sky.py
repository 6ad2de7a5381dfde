"""Which physics buys which digit: the solar system against JPL DE440."""

from __future__ import annotations

from typing import Any

from cross_checks.record import Record
from reports.page.report_data import ReportData
from reports.page.section import Section

LEAD = (
    "Significant figures of each body's place after 360 days against JPL DE440: planets seen from the Sun, the Moon "
    "from the Earth. Each row adds physics to the one before; an integrator that keeps the "
    "energy can still lose the Moon."
)
NAMES = {
    "lumped": "Newton, Earth and Moon as one", "newton": "Newton", "gr_sun": "+ relativity of the Sun alone",
    "gr": "+ relativity (EIH)", "j2": "+ J2 of Sun and Earth", "asteroids": "+ 16 asteroids",
    "full": "+ Moon's figure and tide, Kuiper ring",
}  # fmt: skip


def context(data: ReportData) -> dict[str, Any]:
    judged = [record for record in data.sky if record.figures]
    bodies = list(dict.fromkeys(name for record in judged for name in record.figures))
    return {"bodies": bodies, "rows": [_row(record, bodies) for record in judged]}


def _row(record: Record, bodies: list[str]) -> dict[str, Any]:
    planets = [value for name, value in record.figures.items() if name != "moon"]
    cells = [f"{record.figures[name]:.2f}" if name in record.figures else "not in it" for name in bodies]
    return {
        "model": NAMES[str(record.parameters["model"])],
        "method": f"{record.engine} {record.method}",
        "worst": f"{min(planets):.2f}",
        "cells": cells,
    }


SECTION = Section("sky", "The solar system: which physics buys which digit", LEAD, 75, context)
