"""The validation matrix: every method of every engine against the truth of every scene."""

from __future__ import annotations

from typing import Any

from cross_checks.judge.vocabulary import ANSWERS, MEANINGS, Cell, TargetResult, refusals
from reports.drawing.numbers import ABSENT, in_words, metres, of_scene, order_of, setting, short
from reports.drawing.section import Section
from reports.facts.report_data import ReportData

LEAD = (
    "What each method does on each scene it takes. Errors are over the scene's own scales: position over its length, "
    "angles in rad, velocities over length by time; the largest component of any body at any output counts."
)


def view(cell: Cell) -> dict[str, Any]:
    """Return what a cell shows: its verdict with code and tone, figures, targets, and the command that repeats it."""
    return {
        "scene": cell.label,
        "engine": cell.engine,
        "method": cell.method,
        "word": cell.verdict,
        "code": cell.code,
        "tone": cell.tone,
        "meaning": MEANINGS[cell.verdict].sentence,
        "reason": cell.reason or ABSENT,
        "exemption": cell.exemption,
        "error": of_scene(cell.error),
        "setting": in_words(cell.setting) or ABSENT,
        "compliance": metres(cell.compliance),
        "order": order_of(cell.order, cell.documented_order),
        "targets": [_target(result) for result in cell.targets],
        "command": f"mbs-ref rerun {cell.name}",
    }


def _target(result: TargetResult) -> dict[str, str]:
    word, tone = ANSWERS[result.answer]
    text = word if result.record is None else setting(result.record.settings)
    return {"target": short(result.target), "tone": tone, "text": text, "reason": result.reason}


def context(data: ReportData) -> dict[str, Any]:
    ran = [view(c) for c in data.cells if not c.is_refused]
    targets = list(dict.fromkeys(target["target"] for row in ran for target in row["targets"]))
    return {
        "rows": ran, "refused": refusals(data.cells), "targets": targets,
        "several_scenes": len(data.scenes) > 1, "several_engines": len(data.engines) > 1,
    }  # fmt: skip


SECTION = Section("matrix", "Verdicts by method", LEAD, context)
