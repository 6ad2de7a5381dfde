"""The validation matrix: every method of every engine against the truth of every scene."""

from __future__ import annotations

from typing import Any

from reports.drawing.numbers import ABSENT, in_words, metres, of_scene, short
from reports.drawing.section import Section
from reports.facts.report_data import Cell, ReportData
from reports.page.verdicts import verdict

LEAD = (
    "What each method does on each scene it takes. Errors are over the scene's own scales: position over its length, "
    "angles in rad, velocities over length by time; the largest component of any body at any output counts."
)
ANSWERS = {"reached": "good", "not-reached": "bad", "not-tried": "fair", "unjudged": "plain", "cannot": "plain"}


def view(cell: Cell) -> dict[str, Any]:
    """Return what a cell shows: its verdict with tone, figures, targets, and the command that makes it again."""
    known = verdict(cell.verdict)
    return {
        "scene": cell.scene,
        "engine": cell.engine,
        "method": cell.method,
        "word": cell.verdict,
        "tone": "fair" if known.tone == "bad" and cell.excuse else known.tone,
        "meaning": known.meaning,
        "reason": cell.reason or ABSENT,
        "excuse": cell.excuse,
        "error": of_scene(cell.error),
        "setting": in_words(cell.setting) or ABSENT,
        "compliance": metres(cell.compliance),
        "order": ABSENT if cell.order is None else f"{short(cell.order)} of {cell.documented_order}",
        "targets": [_target(target) for target in cell.targets],
        "command": f"mbs-ref rerun {cell.name}",
    }


def _target(target) -> dict[str, str]:
    told = in_words(target.setting) if target.answer == "reached" else target.answer
    return {"target": short(target.target), "tone": ANSWERS[target.answer], "text": told, "reason": target.reason}


def context(data: ReportData) -> dict[str, Any]:
    ran = [view(c) for c in data.cells if c.verdict not in ("cannot", "engine-missing")]
    targets = list(dict.fromkeys(target["target"] for row in ran for target in row["targets"]))
    return {
        "rows": ran, "refused": refused(data), "targets": targets,
        "several_scenes": len(data.scenes) > 1, "several_engines": len(data.engines) > 1,
    }  # fmt: skip


def refused(data: ReportData) -> list[dict[str, str]]:
    """Return who takes no part and why, methods of one reason together."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for cell in data.cells:
        if cell.verdict in ("cannot", "engine-missing"):
            groups.setdefault((cell.scene, cell.engine, cell.reason), []).append(cell.method)
    return [
        {"scene": scene, "engine": engine, "methods": ", ".join(methods), "reason": reason}
        for (scene, engine, reason), methods in groups.items()
    ]


SECTION = Section("matrix", "Verdicts by method", LEAD, context)
