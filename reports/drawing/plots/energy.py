"""Energy drift over time: what the integration created or lost."""

from __future__ import annotations

from typing import Any

from cross_checks.records.record import Record
from reports.drawing.plots.history import history


def energy(records: list[Record]) -> dict[str, Any] | None:
    """Return the figure of |E(t) - E(0) - work| (J) over time (s)."""
    return history(records, "energy_drift", "|energy − initial − work|, J")
