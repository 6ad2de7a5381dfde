"""Contact: what jumps and kinks do to methods, what the laws return, and the tracked vehicle of Fox 2001."""

from __future__ import annotations

from typing import Any

from reports.drawing.plots.figure import new_figure, to_data
from reports.drawing.plots.histories import histories
from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.studies.contact.facts import ContactFacts

LEAD = (
    "A contact force jumps or bends where bodies touch and part. A step across such a place costs a method its order; "
    "with the place located and the contact's mode frozen inside each step the order comes back."
)


def context(data: ReportData) -> dict[str, Any]:
    facts = data.study(ContactFacts)
    if facts is None:
        return {"contact": None}
    return {
        "contact": facts,
        "order_plot": _orders(facts),
        "plots": {label: histories(curves) for label, curves in facts.curves.items()},
    }


def _orders(facts: ContactFacts) -> dict[str, Any]:
    figure = new_figure("steps over 0.4 s", "error of the speed after the bounce, m/s")
    for ladder in facts.orders:
        figure.add_scatter(
            x=list(ladder.steps), y=[max(e, 1e-17) for e in ladder.errors], mode="lines+markers",
            name=f"{ladder.law}, events {ladder.events}", line={"dash": "dot" if ladder.events == "none" else "solid"},
        )  # fmt: skip
    return to_data(figure)


SECTION = Section("contact", "Contact", LEAD, context)
