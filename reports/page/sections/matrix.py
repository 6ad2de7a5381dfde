"""The validation matrix: every engine and method against every scene."""

from __future__ import annotations

from typing import Any

from reports.page.numbers import ABSENT, metres, short
from reports.page.report_data import Cell, ReportData
from reports.page.section import Section
from reports.page.verdicts import verdict

LEAD = "Each cell says whether an engine's method reaches a scene's truth. Click a cell for its reason and figures."


def view(cell: Cell | None, key: str) -> dict[str, str]:
    """Return what a cell shows: a verdict word with tone, a figure, and the details behind it."""
    if cell is None:
        return {"key": key, "word": "not run", "tone": "plain", "meaning": "left out of this report", "reason": "",
                "figure": ABSENT, "error": ABSENT, "compliance": ABSENT, "order": ABSENT}  # fmt: skip
    known = verdict(cell.verdict)
    return {
        "key": key,
        "word": cell.verdict or "not run",
        "tone": known.tone,
        "meaning": known.meaning,
        "reason": cell.reason,
        "figure": metres(cell.error) if known.tone != "plain" else ABSENT,
        "error": metres(cell.error),
        "compliance": metres(cell.compliance),
        "order": short(cell.order),
    }


def rows(data: ReportData) -> list[dict[str, Any]]:
    """Return one row for each engine and method, with one cell a scene."""
    found = {(c.engine, c.method, c.scene): c for c in data.cells}
    table = []
    for engine in data.engines:
        methods = list(dict.fromkeys(c.method for c in data.cells if c.engine == engine))
        for k, method in enumerate(methods):
            cells = [view(found.get((engine, method, s)), f"c{len(table)}-{j}") for j, s in enumerate(data.scenes)]
            table.append({"engine": engine, "span": len(methods) if k == 0 else 0, "method": method, "cells": cells})
    return table


def context(data: ReportData) -> dict[str, Any]:
    return {"rows": rows(data), "scenes": data.scenes}


SECTION = Section("matrix", "Validation matrix", LEAD, context)
