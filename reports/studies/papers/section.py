"""The papers, claim by claim, and their figures beside ours."""

from __future__ import annotations

from collections import Counter
from typing import Any

from reports.drawing.plots.histories import histories
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.studies.papers.claims import Claim, Figures, claims
from reports.studies.papers.facts import PapersFacts

LEAD = (
    "Fox, Jennings and Zomaya, IEEE Trans. Biomed. Eng. 46(10), 1999, and Computing in Science and Engineering 3(1), "
    "2001, claim by claim. Neither prints masses, stiffnesses or tolerances: what is held against them are sourced "
    "data of this project, so that a figure may differ for that reason alone."
)
TONES = {"reproduced": "good", "there": "good", "partly": "fair", "not reproduced": "bad"}


def context(data: ReportData) -> dict[str, Any]:
    facts = data.study(PapersFacts)
    if facts is None:
        return {"papers": None}
    groups: dict[str, list[dict[str, Any]]] = {}
    for claim in claims():
        groups.setdefault(claim.group, []).append(_row(claim, facts.figures))
    counted = Counter(row["verdict"] for rows in groups.values() for row in rows)
    return {
        "papers": facts,
        "groups": groups,
        "counted": ", ".join(f"{number} {verdict}" for verdict, number in counted.most_common()),
        "plots": {name: histories(curve) for name, curve in facts.curves.items()},
    }


def _row(claim: Claim, figures: Figures) -> dict[str, Any]:
    """Return what the page shows of a claim."""
    verdict = claim.judged(figures)
    return {
        "paper": claim.paper, "where": claim.where, "said": claim.said, "found": claim.told(figures),
        "verdict": verdict, "tone": TONES.get(verdict, "plain"), "link": claim.link,
    }  # fmt: skip


SECTION = Section("papers", "The papers and we", LEAD, context)
