"""The truths: how each was found, how well it is known, and what it may judge."""

from __future__ import annotations

from typing import Any

from reports.drawing.numbers import ABSENT, metres, short
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.facts.truth_facts import TruthFacts

LEAD = (
    "What the errors are measured from. A truth judges no error that is less than 30 times larger than its own "
    "uncertainty. Certified truths are kept with the project; mbs-ref certify makes one again."
)


def row(facts: TruthFacts) -> dict[str, Any]:
    """Return a scene's line of the table."""
    if facts.none:
        return {"scene": facts.scene, "none": facts.none}
    certified = facts.certified or "no certificate"
    off = "" if facts.departs_by is None else f"off by {metres(facts.departs_by)}"
    return {
        "scene": facts.scene, "none": "", "kind": facts.kind, "how": facts.how,
        "uncertainty": metres(facts.uncertainty),
        "floor": short(facts.floor), "difference": metres(facts.difference), "length": metres(facts.length),
        "confirmed": ABSENT if facts.confirmed_to is None else metres(facts.confirmed_to), "by": facts.confirmed_by,
        "tone": "good" if facts.certified else "plain", "word": certified, "kept": off,
    }  # fmt: skip


def context(data: ReportData) -> dict[str, Any]:
    return {"rows": [row(facts) for facts in data.truths]}


SECTION = Section("truths", "Truths", LEAD, context)
