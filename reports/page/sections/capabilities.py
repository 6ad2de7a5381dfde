"""What each engine can model, derived from its adapter."""

from __future__ import annotations

from typing import Any

from reports.drawing.section import Section
from reports.facts.report_data import Capability, ReportData

LEAD = "Asked of the adapters themselves: what each engine models, never will by its nature, or is not taught yet."
WORDS = {"can": ("good", "can"), "some": ("fair", "some methods"), "not-yet": ("plain", "not yet"),
         "never": ("bad", "never"), "missing": ("plain", "engine missing")}  # fmt: skip
TITLES = {"part": "Parts of a scene", "trait": "Traits of a scene"}


def _view(found: Capability | None) -> dict[str, str]:
    if found is None:
        return {"tone": "plain", "word": "not asked", "reason": "no probe for this"}
    tone, word = WORDS[found.answer]
    return {"tone": tone, "word": word, "reason": found.reason}


def context(data: ReportData) -> dict[str, Any]:
    engines = list(dict.fromkeys(c.engine for c in data.capabilities))
    found = {(c.kind, c.name, c.engine): c for c in data.capabilities}
    groups = []
    for kind, title in TITLES.items():
        names = list(dict.fromkeys(c.name for c in data.capabilities if c.kind == kind))
        rows = [{"name": n, "cells": [_view(found.get((kind, n, e))) for e in engines]} for n in names]
        groups.append({"title": title, "rows": rows})
    return {"engines": engines, "groups": groups}


SECTION = Section("capabilities", "Capabilities", LEAD, context)
