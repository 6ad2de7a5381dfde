"""What every section shows of a scene, an engine or a figure, whatever the section: rules over all pages and plots."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from cross_checks.records.plots import style_of
from reports.facts.report_data import ReportData, contenders
from reports.page.render import SCENE, pages
from tests.reports.page.synthetic_report import report_data
from tests.reports.page.test_shown_figures import LINKS, irregular


@pytest.fixture(scope="module")
def data() -> ReportData:
    """Return an irregular report whose runs have curves over time, with one documented order for each method."""
    made = irregular(2)
    curves = {"t": [0.0, 0.5, 1.0], "error": [0.0, 1e-7, 2e-7], "compliance_position": [0.0, 1e-9, 2e-9]}
    history = curves | {"energy_drift": [0.0, 1e-4, 3e-4]}
    runs = tuple(replace(run, history=history if run.error else {}) for run in made.records)
    cells = tuple(replace(one, documented_order=1 + len(one.engine + one.method) % 5) for one in made.cells)
    return replace(made, cells=cells, records=runs, extremes=report_data().extremes)


@pytest.fixture(scope="module")
def contexts(data) -> dict[tuple[str, str], dict[str, Any]]:
    """Return what its template is given, of every section of every page, by the page's title and the section's name."""
    return {(page.title, own.name): own.context(page.data) for page in pages(data) for own in page.sections}


def shown(value: Any) -> Any:
    """Return plain data, in which all that a run holds stands for it."""
    return json.loads(json.dumps(value, default=lambda one: vars(one) if hasattr(one, "__dict__") else str(one)))


def test_the_part_of_a_scene_is_that_of_a_report_on_it_alone(data, contexts):
    """Whatever a section of a scene's page shows by scene, its part of each is what it shows of that scene's data."""
    met: set[str] = set()
    for section in SCENE:
        whole = section.context(data)
        for label in data.scenes:
            for key, value in contexts[label, section.name].items():
                if isinstance(value, dict) and value and set(value) <= {label}:
                    assert shown(whole[key][label]) == shown(value[label]), (section.name, key)
                    met.add(f"{section.name}.{key}")
    assert {"prices.plots", "prices.tables", "prices.never", "compliance.compliance", "compliance.error",
            "energy.plots", "time_split.plots", "convergence.by_step", "records.groups"} <= met  # fmt: skip


def dicts_in(value: Any) -> Iterator[dict[str, Any]]:
    """Yield every dict within a value."""
    if isinstance(value, dict):
        yield value
        value = tuple(value.values())
    if isinstance(value, list | tuple):
        for held in value:
            yield from dicts_in(held)


def figures_in(value: Any) -> Iterator[dict[str, Any]]:
    """Yield the figures of plotly within a value."""
    return (one for one in dicts_in(value) if {"data", "layout"} <= one.keys())


def test_an_engine_has_its_own_colour_and_symbol_in_every_figure(contexts):
    count = 0
    for place, context in contexts.items():
        for figure in figures_in(context):
            for line in figure["data"]:
                if (engine := line.get("meta", {}).get("engine")) is not None:
                    style = style_of(engine)
                    drawn = line["line"]["color"], line["marker"]["color"], line["legendgroup"]
                    assert drawn == (style.colour, style.colour, engine), place
                    assert line["marker"]["symbol"].removesuffix("-open") == style.symbol
                    count += 1
    assert count > 100


def test_every_figure_says_what_its_axes_are(contexts):
    """A title on both axes with a unit or what it is a share of, or names in place of numbers."""
    for place, context in contexts.items():
        for figure in figures_in(context):
            for axis in ("xaxis", "yaxis"):
                shown = figure["layout"][axis]
                is_listed = all(isinstance(x, str) for line in figure["data"] for x in line[axis[0]] if x is not None)
                assert shown["title"]["text"] or is_listed, (place, axis)


def test_a_row_names_scene_and_engine_of_one_cell_or_run(data, contexts):
    pairs = {(one.label, one.engine) for one in (*data.cells, *data.records)}
    for place, context in contexts.items():
        for row in dicts_in(context):
            if {"scene", "engine"} <= row.keys():
                assert (row["scene"], row["engine"]) in pairs, place


def test_all_runs_near_the_cheapest_are_timed_again(data):
    """Each engine's runs at each target that take at most half as long again as its first choice."""
    expected: set[int] = set()
    for links in LINKS:
        cells = [cell for cell in data.cells if cell.parameters == {"links": links}]
        for engine in data.engines:
            for target in data.targets:
                found = [result.record for cell in cells if cell.engine == engine for result in cell.targets
                         if result.target == target and result.record]  # fmt: skip
                own = [next(run for run in data.records if (run.label, run.engine, run.method, run.settings) == (
                    one.label, one.engine, one.method, one.settings) and run.error) for one in found]  # fmt: skip
                least = min((run.times["loop_s"] for run in own), default=0.0)
                expected |= {id(run) for run in own if run.times["loop_s"] <= 1.5 * least}
    assert {id(run) for run in contenders(data)} == expected
