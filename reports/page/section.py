"""What a section of the page is: a title, a template and the variables it shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from reports.facts.report_data import ReportData


@dataclass(frozen=True)
class Section:
    """A titled part of the page. `context` makes the template's variables from the data."""

    name: str  # the anchor
    title: str
    lead: str  # one sentence in plain words
    context: Callable[[ReportData], dict[str, Any]]
    template: str = ""  # a study's own; else templates/<name>.html
