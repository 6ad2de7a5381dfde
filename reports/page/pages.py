"""The files of the report: what stands on which page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from reports.drawing.section import Section
from reports.facts.report_data import ReportData
from reports.page import findings
from reports.page.sections import (
    capabilities,
    decisions,
    environment,
    extremes,
    matrix,
    method,
    overview,
    plots,
    prices,
    profiles,
    records,
    truths,
)
from reports.page.slug import engine_file, scene_file
from reports.studies.study import every, section

INDEX = "index.html"
WRONG, ALL_SCENES, METHOD, CAN = "findings.html", "profiles.html", "method.html", "capabilities.html"


@dataclass(frozen=True)
class Page:
    """A file of the report. `data` is what concerns it."""

    file: str
    title: str
    data: ReportData
    sections: tuple[Section, ...]
    kind: str  # index | scene | engine | study | more: where its link stands


def pages(data: ReportData) -> list[Page]:
    """Return every page, the first screen first."""
    return [
        Page(INDEX, "mbs-ref report", data, _of(decisions, overview), "index"),
        *(Page(scene_file(name), name, data.only(scene=name), SCENE, "scene") for name in data.scenes),
        *(Page(engine_file(name), name, data.only(engine=name), ENGINE, "engine") for name in data.engines),
        Page("extremes.html", "Extremes", data, _of(extremes), "study"),
        *_studies(data),
        Page(WRONG, "What went wrong", data, _of(findings), "more"),
        Page(ALL_SCENES, "All scenes at once", data, _of(profiles), "more"),
        Page(CAN, "What each engine can model", data, _of(capabilities), "more"),
        Page(METHOD, "How it is judged and timed", data, _of(method, truths, environment), "more"),
    ]


def _studies(data: ReportData) -> Iterator[Page]:
    """Yield a page for each file that studies name."""
    for (file, title), names in groupby(every(), lambda name: (every()[name].page, every()[name].title)):
        yield Page(file, title, data, tuple(section(name) for name in names), "study")


def _of(*modules) -> tuple[Section, ...]:
    return tuple(module.SECTION for module in modules)


SCENE = (*_of(prices, matrix), *plots.SECTIONS, *_of(truths, records))
ENGINE = _of(decisions, matrix, extremes, capabilities)
