"""The verdict strip: the one sentence a newcomer reads first."""

from __future__ import annotations

from collections import Counter
from typing import Any

from reports.page.findings import grouped
from reports.page.numbers import count
from reports.page.report_data import ReportData
from reports.page.section import Section
from reports.page.verdicts import VERDICTS, verdict


def sentence(data: ReportData) -> str:
    """Say how many of the cells that ran agree with the truth."""
    tones = Counter(verdict(cell.verdict).tone for cell in data.cells)
    ran = tones["good"] + tones["fair"] + tones["bad"]
    if not data.cells:
        return "No validation was run: this page holds timings only."
    good, fair, bad = (tones[tone] for tone in ("good", "fair", "bad"))
    return (
        f"{good} of {count(ran, 'cell')} that ran agree with the truth; "
        f"{fair or 'none'} approach it, {bad or 'none'} flagged."
    )


def flagged(data: ReportData) -> list[str]:
    """Name each combination that reaches another answer: the most dangerous kind."""
    return [
        f"{engine} {methods} on {', '.join(dict.fromkeys(c.scene for c in cells))} converges to another answer."
        for engine, methods, cells in grouped(data, {"wrong-limit"})
    ]


def chips(data: ReportData) -> list[dict[str, Any]]:
    """Return the verdicts met with their counts, in the order of the vocabulary."""
    counts = Counter(cell.verdict for cell in data.cells)
    words = [*VERDICTS, *(word for word in counts if word not in VERDICTS)]
    known = [(word, verdict(word), counts[word]) for word in words if counts[word]]
    return [{"word": word, "tone": v.tone, "meaning": v.meaning, "count": n} for word, v, n in known]


def context(data: ReportData) -> dict[str, Any]:
    return {"sentence": sentence(data), "flagged": flagged(data), "chips": chips(data)}


SECTION = Section("verdict", "Verdict", "", context)
