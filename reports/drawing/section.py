"""What a section of the page is: a title, a template and the variables it shows."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from reports.facts.report_data import ReportData


@dataclass(frozen=True)
class Finding:
    """One sentence with its title and tone (good | fair | bad | plain)."""

    tone: str
    title: str
    text: str


def nothing(data: ReportData) -> Iterable[Finding]:
    """Find nothing."""
    return ()


@dataclass(frozen=True)
class Section:
    """A titled part of the page. `context` makes the template's variables from the data."""

    name: str  # the anchor
    title: str
    lead: str  # one sentence in plain words
    context: Callable[[ReportData], dict[str, Any]]
    findings: Callable[[ReportData], Iterable[Finding]] = nothing  # what the first screen should tell of it
    template: str = ""  # where it is not <name>.html
