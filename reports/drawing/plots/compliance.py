"""Constraint compliance over time: how far the joints gape."""

from __future__ import annotations

from typing import Any

from cross_checks.records.record import Record
from reports.drawing.plots.history import history


def compliance(records: list[Record]) -> dict[str, Any] | None:
    """Return the figure of the largest |C(q, t)| (m, rad) over time (s)."""
    return history(records, "compliance_position", "largest |C(q, t)|, m or rad")
