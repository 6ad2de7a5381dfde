"""Distance from the truth over time: when a solution goes astray."""

from __future__ import annotations

from typing import Any

from cross_checks.records.record import Record
from reports.drawing.plots.history import history
from reports.drawing.plots.palette import Style


def error_history(records: list[Record], styles: dict[tuple[str, str], Style]) -> dict[str, Any] | None:
    """Return the figure of the error over the scene's scales over time (s)."""
    return history(records, styles, "error", "error over the scene's scales")
