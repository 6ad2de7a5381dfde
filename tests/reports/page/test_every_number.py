"""Whole pages: every number of a page's text is one that the page's sections computed, and none of those is lost.

What the sections compute is recomputed from the records in `test_recomputed_pages` and its neighbours.
"""

from __future__ import annotations

import json
import random
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from html import unescape
from typing import Any

import pytest

from cross_checks.records import numbers
from reports.facts.curves import Measured
from reports.page.render import TEMPLATES, pages, render
from reports.studies.study import every
from tests.reports.page.synthetic_report import report_data
from tests.reports.page.test_recomputed_pages import shown, value
from tests.reports.page.test_shown_figures import irregular

NUMBER = re.compile(r"(?<![\w.])-?\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]*[a-df-zA-DF-Z_])")
UNSEEN = re.compile(r"<(script|style|svg|head|nav|template)\b.*?</\1>|<!--.*?-->", re.DOTALL)
DRAWN = ("plot", "plots", "pick_rows", "compliance", "error", "by_step", "by_tolerance", "mechanisms")
FORMS = (
    numbers.short,
    numbers.metres,
    numbers.duration,
    numbers.of_scene,
    "{:.3g}".format,
    "{:.4f}".format,
    str,
    "{:,}".format,
)


def text_of(html: str) -> str:
    return unescape(re.sub(r"<[^>]*>", " ", UNSEEN.sub(" ", html)))


def words_of(value: Any) -> Iterator[str]:
    """Yield every text and every number, in each form that a template may give it, within a value."""
    if isinstance(value, bool) or value is None:
        return
    if isinstance(value, str):
        yield value
    elif isinstance(value, int | float):
        yield from (form(value) for form in FORMS)  # type: ignore[operator]
    elif isinstance(value, dict):
        for key, held in value.items():
            yield from words_of(key)
            yield from () if key in DRAWN and isinstance(held, dict) else words_of(held)
    elif isinstance(value, list | tuple | set):
        yield str(len(value))
        for held in value:
            yield from words_of(held)
    elif hasattr(value, "__dict__"):
        yield from words_of({key: held for key, held in vars(value).items() if not key.startswith("_")})


def found(text: str) -> list[str]:
    return NUMBER.findall(text)


@cache
def fixed(template: str) -> frozenset[str]:
    """Return the numbers that a template and those that it includes write themselves."""
    source = (TEMPLATES / template).read_text()
    included = re.findall(r"""(?:include|import|extends|from) ["'](\w+\.html)""", source)
    own = found(text_of(re.sub(r"{%.*?%}|{#.*?#}|{{.*?}}", " ", source, flags=re.DOTALL)))
    return frozenset(own).union(*map(fixed, included))


def unexplained(file: str, html: str, data: Any) -> Counter[str]:
    """Return the numbers of a page's text that neither its sections computed nor its templates hold."""
    (page,) = (one for one in pages(data) if one.file == file)
    given = {"scenes": page.data.scenes, "absence": data.absence, "title": page.title, "environment": data.environment}
    contexts = [section.context(page.data) for section in page.sections]
    held = given, *contexts, [section.lead for section in page.sections]
    known = {one for text in words_of(held) for one in found(text)}
    for name in ("page.html", "section.html", *(s.template or f"{s.name}.html" for s in page.sections)):
        known |= fixed(name)
    return Counter(one for one in found(text_of(html)) if one not in known)


def lost(file: str, html: str, data: Any) -> list[str]:
    """Return the texts of rows, with a number, that a page shows nowhere, not even where one points at a cell."""
    (page,) = (one for one in pages(data) if one.file == file)
    own = [section for section in page.sections if section.name in ("landscape", "prices", "profiles", "findings")]
    texts = [text for section in own for text in texts_in(section.context(page.data))]
    return [text for text in texts if found(text) and text not in unescape(html)]


def texts_in(context: Any) -> Iterator[str]:
    """Yield what stands in the cells of a section's rows and blocks."""
    if isinstance(context, str):
        yield context
    elif isinstance(context, dict):
        for key, held in context.items():
            if key not in ("plot", "plots", "pick_rows", "never", "file", "files"):
                yield from texts_in(held)
    elif isinstance(context, list | tuple):
        for held in context:
            yield from texts_in(held)


@pytest.fixture(scope="module", params=(1, 2))
def report(request) -> tuple[Any, dict[str, bytes]]:
    data = replace(irregular(request.param), environment={"made": "2026-01-02"}, extremes=report_data().extremes)
    return data, render(data)


def test_every_number_of_a_page_is_one_that_its_sections_computed(report):
    data, files = report
    counted = {}
    for page in pages(data):
        html = files[page.file].decode()
        assert not unexplained(page.file, html, data), page.file
        assert not lost(page.file, html, data), page.file
        counted[page.file] = len(found(text_of(html)))
    assert min(counted[file] for file in ("index.html", "profiles.html", "method.html")) > 60
    assert all(count > 60 for file, count in counted.items() if file.startswith(("scene-", "engine-")))


DIGITS = {"short": (2, 1.0), "short3": (3, 1.0), "duration": (3, 1.0), "metres": (2, 1.0), "joules": (2, 1.0),
          "kilo": (3, 1e-3), "milli": (3, 1e3)}  # fmt: skip
PLACE = re.compile(r"\{([^{}:|\"]+)(?::([^{}|\"]+))?(?:\|[^{}\"]*)?\}")
Table = tuple[dict[str, str], dict[str, Any]]  # the texts of columns, and the values of one row


def made_up(blocks: list[dict[str, Any]], row: dict[str, Any], chance: random.Random) -> Iterator[tuple[str, Table]]:
    """Yield the tables of a study by name, each with a row of words and, where a text has a format, of numbers."""
    for block in blocks:
        values: dict[str, Any] = {}
        for name, form in PLACE.findall(json.dumps(block.get("columns") or block.get("blocks") or "")):
            number = chance.randrange(1, 10**5) if form == "d" else 10 ** chance.uniform(-9, -0.1)
            values[name] = number if form else values.get(name, f" word{chance.choice('xyz')}")
        if isinstance(block.get("each"), str):
            yield block["each"], ({}, values)
            yield from made_up(block["blocks"], values, chance)
        elif "each" in block:
            yield from made_up(block["blocks"], row, chance)
        elif "table" in block and "columns" in block:
            name = PLACE.sub(lambda place: str(row[place[1]]), block["table"]).replace("*", "all")
            yield name, (block["columns"], values)


def expected(text: str, values: dict[str, Any]) -> list[Any]:
    """Return the numbers of a cell, in SI units but for those that its heading names."""
    numbers = []
    for name, form in PLACE.findall(text):
        digits, factor = DIGITS.get(form, (0, 1.0))
        if form:
            numbers.append(shown(factor * values[name], digits) if digits else float(format(values[name], form)))
    return numbers


@pytest.mark.parametrize("name", ["androids", "contact", "pairs"])
def test_every_number_in_the_tables_of_a_study_is_that_of_its_row(name):
    document = every()[name]
    made = dict(made_up(document.blocks, {}, random.Random(name)))
    measured = Measured({"pairs.places": 1.0}, {title: (values,) for title, (_, values) in made.items()})
    html = render(replace(report_data(), studies={name: measured}))[document.page].decode()
    rows = [re.findall(r"<td.*?</td>", row, re.DOTALL) for row in re.findall(r"<tr>(<td.*?)</tr>", html, re.DOTALL)]
    printed = [[text_of(cell).strip() for cell in row] for row in rows]
    wanted = [[expected(text, values) for text in columns.values()] for columns, values in made.values() if columns]
    assert sum(map(bool, wanted)) == len(printed) >= 2
    for row, own in zip(printed, wanted, strict=True):
        assert [[value(cell[cell.index(one) :]) for one in found(cell)] for cell in row] == own
