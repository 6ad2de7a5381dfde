"""What models cost: from least to most, with the least that is enough."""

from __future__ import annotations

import math
from typing import Any

from reports.drawing.numbers import ABSENT, duration, short
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.studies.models.facts import Ladder, ModelsFacts, Rung

LEAD = (
    "Model only what a scene requires: each ladder runs the same scene with more and more in the model, by one method "
    "and setting, in interleaved turns. The price is the time of the loop; what it buys stands beside it."
)


def context(data: ReportData) -> dict[str, Any]:
    facts = data.study(ModelsFacts)
    if facts is None:
        return {"ladders": None}
    return {"ladders": [_table(ladder) for ladder in facts.ladders]}


def _table(ladder: Ladder) -> dict[str, Any]:
    shown = list(dict.fromkeys(name for rung in ladder.rungs for name in rung.shown))
    first, measured = ladder.rungs[0].loop_s, [ladder.measure] if ladder.measure else []
    return {
        "title": ladder.title, "note": ladder.note, "method": ladder.method,
        "head": ["model", "time", "over the first", "right-hand sides", *measured, *shown],
        "rows": [_cells(rung, shown, first, bool(measured)) for rung in ladder.rungs],
        "least": _least(ladder),
    }  # fmt: skip


def _cells(rung: Rung, shown: list[str], first: float, is_measured: bool) -> list[str]:
    accuracy = [ABSENT if rung.accuracy is None else f"{rung.accuracy:.1f}"] if is_measured else []
    figures = [short(rung.shown.get(name), 3) for name in shown]
    return [rung.name, duration(rung.loop_s), f"{rung.loop_s / first:.3g}", str(rung.work), *accuracy, *figures]


def _least(ladder: Ladder) -> list[str]:
    """Say for each whole figure which is the least model that reaches it, where that changes."""
    reached = [rung.accuracy for rung in ladder.rungs if rung.accuracy is not None]
    if not reached:
        return []
    most: dict[str, int] = {}
    for figures in range(1, math.floor(max(reached)) + 1):
        rung = ladder.least(figures)
        if rung is not None:
            most[rung.name] = figures
    return [f"up to {figures}: {name}" for name, figures in most.items()]


SECTION = Section("models", "What a model costs", LEAD, context)
