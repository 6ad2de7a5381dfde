"""What a section of the page is. Each lives in its own file under sections/, with its template."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from reports.page import sections as folder
from reports.page.report_data import ReportData


@dataclass(frozen=True)
class Section:
    """A titled part of the page. `context` makes the template's variables from the data."""

    name: str  # the anchor, and the template templates/<name>.html
    title: str
    lead: str  # one sentence in plain words
    place: int  # sections are ordered by this
    context: Callable[[ReportData], dict[str, Any]]
    plots: bool = False  # shown beneath the toolbar that chooses scene and engines


def discover() -> list[Section]:
    """Return every section found in the folder, in order."""
    modules = [importlib.import_module(f"{folder.__name__}.{m.name}") for m in pkgutil.iter_modules(folder.__path__)]
    return sorted((module.SECTION for module in modules), key=lambda section: section.place)
