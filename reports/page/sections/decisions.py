"""The first screen: for each engine one line to act on, and where to go next."""

from __future__ import annotations

from collections import Counter
from typing import Any

from cross_checks.judge.vocabulary import Verdict
from reports.drawing.numbers import count
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.page.advice import advice
from reports.page.slug import engine_file

LEAD = (
    "Which engine to trust for what, from the runs of this report. An error of 1e-6 is a millionth of the scene's own "
    "size; times are of the integration loop at equal error."
)


def context(data: ReportData) -> dict[str, Any]:
    lines = advice(data)
    absent = [line.engine for line in lines if line.missing] if len(lines) > 1 else []
    return {
        "advice": [line for line in lines if line.engine not in absent], "absent": absent,
        "files": {name: engine_file(name) for name in data.engines}, "told": told(data),
    }  # fmt: skip


def told(data: ReportData) -> str:
    """Say how many cells there are, and what became of them."""
    if not data.cells:
        return "No validation was run: this page holds no cells."
    counts = Counter(cell.verdict for cell in data.cells)
    parts = ", ".join(f"{counts[word]} {word}" for word in Verdict if counts[word])
    return f"{count(len(data.cells), 'cell')} of {count(len(data.scenes), 'scene')} and every method: {parts}."


SECTION = Section("decisions", "Which engine for what", LEAD, context)
