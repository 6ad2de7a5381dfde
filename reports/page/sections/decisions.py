"""The first screen: a line for each engine, and every scene with its cheapest setting at each target."""

from __future__ import annotations

from collections import Counter
from typing import Any

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import ANSWERS, OURS, Verdict
from cross_checks.records.cost import loop_time
from cross_checks.records.numbers import count, duration, short
from reports.facts.cheapest import Entry, entries
from reports.facts.report_data import ReportData, Section
from reports.page.advice import advice
from reports.page.slug import engine_file, scene_file

LEAD = (
    "Which engine to trust for what, from the runs of this report. An error of 1e-6 is a millionth of the scene's own "
    "size; times are of the integration loop at equal error."
)


def context(data: ReportData) -> dict[str, Any]:
    lines = advice(data)
    absent = [line.engine for line in lines if line.missing] if len(lines) > 1 else []
    return {
        "advice": [line for line in lines if line.engine not in absent], "absent": absent,
        "files": {name: engine_file(name) for name in data.engines}, "told": counted(data),
    }  # fmt: skip


def counted(data: ReportData) -> str:
    """Say how many cells there are, and what became of them."""
    if not data.cells:
        return "No validation was run: this page holds no cells."
    counts = Counter(cell.verdict for cell in data.cells)
    parts = ", ".join(f"{counts[word]} {word}" for word in Verdict if counts[word])
    return f"{count(len(data.cells), 'cell')} of {count(len(data.scenes), 'scene')} and every method: {parts}."


SECTION = Section("decisions", "Which engine for what", LEAD, context)


SCENES_LEAD = (
    "The cheapest engine at each target error, with our own solver beside it. A scene's page has every engine."
)


def scenes_context(data: ReportData) -> dict[str, Any]:
    rows = [{"scene": scene, "file": scene_file(scene), "cells": _cells(data, scene)} for scene in data.scenes]
    return {"targets": [short(target) for target in TARGETS], "rows": rows}


def _cells(data: ReportData, scene: str) -> list[dict[str, Any]]:
    result = []
    for target in TARGETS:
        listed = entries(data, scene, target)
        rivals = [entry for entry in listed if entry.engine != OURS]
        ours = next((entry for entry in listed if entry.engine == OURS), None)
        best = next((entry for entry in rivals if entry.best), None)
        reached = sum(entry.best is not None for entry in rivals)
        result.append(
            {"best": answer_of(best) if best else _missed(rivals), "ours": answer_of(ours), "reached": reached}
        )
    return result


def answer_of(entry: Entry | None) -> str:
    """Return an engine's answer in a few words."""
    if entry is None:
        return "not run"
    if entry.best is None:
        return ANSWERS[entry.answer][0]
    return f"{entry.engine} {entry.method}, {duration(loop_time(entry.best))}"


def _missed(rivals: list[Entry]) -> str:
    answers = {entry.answer for entry in rivals} - {"cannot"}
    return next((f"none: {word}" for answer, (word, _) in ANSWERS.items() if answer in answers), "none can")


SCENES = Section("overview", "Scenes", SCENES_LEAD, scenes_context)
