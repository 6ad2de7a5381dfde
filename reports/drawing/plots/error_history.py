"""Distance from the truth over time: when a solution goes astray."""

from __future__ import annotations

from typing import Any

from cross_checks.records.record import Record
from reports.drawing.plots.history import history


def error_history(records: list[Record]) -> dict[str, Any] | None:
    """Return the figure of the error over the scene's scales over time (s)."""
    return history(records, "error", "error over the scene's scales")
