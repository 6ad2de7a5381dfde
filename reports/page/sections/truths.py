"""The truths: how each was found, how well it is known, and what it may judge."""

from __future__ import annotations

from typing import Any

from cross_checks.truth import NoTruth
from reports.page.numbers import ABSENT, metres
from reports.page.report_data import ReportData
from reports.page.section import Section
from reports.page.truth_facts import TruthFacts

LEAD = (
    "What the errors on this page are measured from. A truth judges no error that is less than 30 times larger than "
    "its own uncertainty; each is made again for this report and held to the certificate kept with the project."
)


def row(facts: TruthFacts) -> dict[str, Any]:
    """Return a scene's line of the table."""
    if isinstance(facts.made, NoTruth):
        return {"scene": facts.scene, "none": facts.made.reason}
    made, kept = facts.made, facts.kept
    words = {None: ("plain", "no certificate"), True: ("good", "holds"), False: ("bad", "departs")}
    tone, word = words[facts.holds]
    return {
        "scene": facts.scene,
        "none": "",
        "kind": made.kind,
        "how": made.how,
        "uncertainty": metres(made.uncertainty),
        "floor": metres(made.floor),
        "difference": metres(made.difference),
        "confirmed": ABSENT if kept is None else metres(kept.confirmed_to),
        "by": "" if kept is None else kept.confirmed_by,
        "tone": tone,
        "word": word,
        "kept": "" if kept is None else f"{kept.made}, off by {metres(facts.departs_by)}",
    }


def context(data: ReportData) -> dict[str, Any]:
    return {"rows": [row(facts) for facts in data.truths]}


SECTION = Section("truths", "Truths", LEAD, context)
