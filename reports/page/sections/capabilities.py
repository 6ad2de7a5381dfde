"""What each engine can model, derived from its adapter."""

from __future__ import annotations

from typing import Any

from cross_checks.judge.capabilities import Ability
from reports.drawing.section import Section
from reports.facts.report_data import ReportData

LEAD = "Derived from the adapters: what each engine models, can never model by its nature, or does not translate yet."
WORDS = {"can": ("good", "can"), "some": ("fair", "some methods"), "not-yet": ("plain", "not yet"),
         "never": ("bad", "never")}  # fmt: skip
TITLES = {"parts": "Parts of a scene", "traits": "Traits of a scene"}


def _view(known: bool | Ability | None) -> dict[str, str]:
    if known is None:
        return {"tone": "plain", "word": "not tested", "reason": "no scene shows this"}
    ability = known if isinstance(known, Ability) else Ability("can" if known else "not-yet")
    tone, word = WORDS[ability.answer]
    return {"tone": tone, "word": word, "reason": ability.reason}


def context(data: ReportData) -> dict[str, Any]:
    able = [one for one in data.capabilities if one.installed]
    groups = []
    for kind, title in TITLES.items():
        names = list(dict.fromkeys(name for one in able for name in getattr(one, kind)))
        rows = [{"name": name, "cells": [_view(getattr(one, kind).get(name)) for one in able]} for name in names]
        groups.append({"title": title, "rows": rows})
    absent = {one.engine: one.reason for one in data.capabilities if not one.installed}
    return {"engines": [one.engine for one in able], "groups": groups, "absent": absent}


SECTION = Section("capabilities", "Capabilities", LEAD, context)
