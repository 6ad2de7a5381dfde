"""The validation matrix, every method of every engine against every truth, and what each engine can model."""

from collections.abc import Collection
from typing import Any

from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.capabilities import Ability
from cross_checks.judge.vocabulary import ANSWERS, MEANINGS, Cell, TargetResult, refusals
from cross_checks.records.numbers import ABSENT, in_words, metres, of_scene, order_of, setting, short
from reports.facts.report_data import ReportData, Section


def view(cell: Cell, targets: Collection[float] = TARGETS) -> dict[str, Any]:
    """Return what a cell shows: its verdict with code and tone, figures, targets, and the command that repeats it."""
    return {
        "scene": cell.label, "engine": cell.engine, "method": cell.method, "word": cell.verdict, "code": cell.code,
        "tone": cell.tone, "meaning": MEANINGS[cell.verdict].sentence, "reason": cell.reason or ABSENT,
        "exemption": cell.exemption, "error": of_scene(cell.error), "setting": in_words(cell.setting) or ABSENT,
        "compliance": metres(cell.compliance), "order": order_of(cell.order, cell.documented_order),
        "targets": [_target(result) for result in cell.targets if result.target in targets],
        "command": f"mbs-ref rerun {cell.name}",
    }  # fmt: skip


def _target(result: TargetResult) -> dict[str, str]:
    word, tone = ANSWERS[result.answer]
    text = word if result.record is None else setting(result.record.settings)
    return {"target": short(result.target), "tone": tone, "text": text, "reason": result.reason}


def context(data: ReportData) -> dict[str, Any]:
    ran = [view(c, data.targets) for c in data.cells if not c.is_refused]
    present = (c for c in data.cells if c.engine not in data.missing)
    targets = list(dict.fromkeys(target["target"] for row in ran for target in row["targets"]))
    return {
        "rows": ran, "refused": refusals(present), "targets": targets,
        "several_scenes": len(data.scenes) > 1, "several_engines": len(data.engines) > 1,
    }  # fmt: skip


SECTION = Section("matrix", "Verdicts by method", context)


WORDS = {"can": ("good", "can"), "some": ("fair", "some methods"), "not-yet": ("plain", "not yet"),
         "never": ("bad", "never")}  # fmt: skip
TITLES = {"parts": "Parts of a scene", "traits": "Traits of a scene"}


def _view(known: bool | Ability | None) -> dict[str, str]:
    if known is None:
        return {"tone": "plain", "word": "not tested", "reason": "no scene shows this"}
    ability = known if isinstance(known, Ability) else Ability("can" if known else "not-yet")
    tone, word = WORDS[ability.answer]
    return {"tone": tone, "word": word, "reason": ability.reason}


def capabilities_context(data: ReportData) -> dict[str, Any]:
    able = [one for one in data.capabilities if one.installed]
    groups = []
    for kind, title in TITLES.items():
        names = list(dict.fromkeys(name for one in able for name in getattr(one, kind)))
        rows = [{"name": name, "cells": [_view(getattr(one, kind).get(name)) for one in able]} for name in names]
        groups.append({"title": title, "rows": rows})
    absent = {one.engine: one.reason for one in data.capabilities if not one.installed}
    return {"engines": [one.engine for one in able], "groups": groups, "absent": absent}


CAPABILITIES = Section("capabilities", "Capabilities", capabilities_context)
