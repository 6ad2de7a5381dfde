"""Every scene with its cheapest setting at each target: the way into the scenes' own pages."""

from __future__ import annotations

from typing import Any

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.vocabulary import ANSWERS, OURS
from reports.drawing.numbers import duration, short
from reports.drawing.section import Section
from reports.facts.cheapest import Entry, entries, loop_time
from reports.facts.report_data import ReportData
from reports.page.slug import scene_file

LEAD = "The cheapest engine at each target error, with our own solver beside it. A scene's page has every engine."


def context(data: ReportData) -> dict[str, Any]:
    rows = [{"scene": scene, "file": scene_file(scene), "cells": _cells(data, scene)} for scene in data.scenes]
    return {"targets": [short(target) for target in TARGETS], "rows": rows}


def _cells(data: ReportData, scene: str) -> list[dict[str, Any]]:
    found = []
    for target in TARGETS:
        listed = entries(data, scene, target)
        rivals = [entry for entry in listed if entry.engine != OURS]
        ours = next((entry for entry in listed if entry.engine == OURS), None)
        best = next((entry for entry in rivals if entry.best), None)
        reached = sum(entry.best is not None for entry in rivals)
        found.append({"best": told(best) if best else _missed(rivals), "ours": told(ours), "reached": reached})
    return found


def told(entry: Entry | None) -> str:
    """Return an engine's answer in a few words."""
    if entry is None:
        return "not asked"
    if entry.best is None:
        return ANSWERS[entry.answer][0]
    return f"{entry.engine} {entry.method}, {duration(loop_time(entry.best))}"


def _missed(rivals: list[Entry]) -> str:
    answers = {entry.answer for entry in rivals} - {"cannot"}
    return next((f"none: {word}" for answer, (word, _) in ANSWERS.items() if answer in answers), "none can")


SECTION = Section("overview", "Scenes", LEAD, context)
