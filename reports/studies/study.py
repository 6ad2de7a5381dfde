"""What a study is, and which there are: found by listing this folder."""

from __future__ import annotations

import pkgutil
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib import import_module
from importlib.resources import files
from typing import Any

from reports import studies
from reports.facts.curves import Measured
from reports.facts.report_data import Section
from reports.studies.document import Document


@dataclass(frozen=True)
class Study:
    """A study, as its study.toml declares it.

    Beside it stands measure.py, whose `measure()` returns a Measured. It may offer `parts()` and `make(part)`: runs
    that the store holds once made, in any order and side by side, for `measure()` to read there. A study without
    study.toml has facts.py with STUDY, and section.py with SECTION and section.html, which show the facts.
    """

    page: str  # its file; studies of one file share a page
    title: str  # of the page
    facts: type | None = None  # None where it shows tables that commands left in the tree
    place: int = 0  # on a shared page; the lowest stands first
    alone: bool = False  # it times things, so that nothing else may run meanwhile


@cache
def every() -> dict[str, Study]:
    """Return every study by its folder's name."""
    names = [module.name for module in pkgutil.iter_modules(studies.__path__) if module.ispkg]
    found = {name: _declared(name) for name in names}
    return dict(sorted(found.items(), key=lambda item: (item[1].page, item[1].place)))


def _declared(name: str) -> Study:
    text = document(name)
    if text is None:
        return import_module(f"reports.studies.{name}.facts").STUDY
    return Study(text.page, text.title, Measured, text.place, text.alone)


@cache
def document(name: str) -> Document | None:
    """Return a study's document; None for a study without one."""
    path = files("reports.studies") / name / "study.toml"
    return Document(name, **tomllib.loads(path.read_text(encoding="utf-8"))) if path.is_file() else None


def measurement(name: str) -> Callable[[], Any]:
    """Return what makes a study's facts."""
    return import_module(f"reports.studies.{name}.measure").measure


def parts(name: str) -> list[Any]:
    """Return the parts of a study that may be made side by side before it is measured; most have none."""
    module = import_module(f"reports.studies.{name}.measure")
    return list(module.parts()) if hasattr(module, "parts") else []


def make(name: str, part: Any) -> None:
    """Make one of them."""
    import_module(f"reports.studies.{name}.measure").make(part)


def section(name: str) -> Section:
    """Return what shows a study."""
    text = document(name)
    if text is not None:
        return Section(text.name, text.heading, text.lead, text.context, text.findings, "document.html")
    return replace(import_module(f"reports.studies.{name}.section").SECTION, template=f"{name}/section.html")
