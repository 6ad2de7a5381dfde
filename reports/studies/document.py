"""A study's document, study.toml: the blocks that present what the study measures.

A block has one of these keys, whose value may contain placeholders:

heading, title    a heading of a section or of a part
text, note        a paragraph of HTML
table             the name of a table; `columns` maps each heading to a cell, all columns without it
plots             the names of curves, a plot each
overlay           the names of curves, all in one plot
films, pictures   the names of films, moving with a strip of moments, or the strip alone
outlines          the names of tables of lines with round ends, drawn at each time
matrix            the columns by heading; `rows` maps each label to a cell, in which `@` stands for the column
claims            the document's claims, by group
each              a table's name: `blocks` are shown once for each row, whose columns are figures there; or a list of
                  words: `blocks` are shown once for each, with `@` replaced by the word

A `*` in a name stands for any characters, which become the heading of what is shown. A block is shown where the
criteria of `where` hold. `layout` is `pairs`, or `details`: a part to open, titled `summary`, which is
open where that contains `open`. `study` names another study, whose facts a block shows.

{name} in a text stands for a measured figure, {name:format} for one in a given format; {name:format|words} shows the
words where the figure is None. A format is one of FORMATS or Python's own.
"""

import json
import operator
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

from markupsafe import Markup, escape

from cross_checks.records.numbers import ABSENT, duration, joules, metres, short
from reports.facts.curves import Measured, overlay
from reports.facts.report_data import ReportData, Section

Verdict = Literal["reproduced", "not reproduced", "partly", "there", "not attempted", "not measured"]
Criterion = tuple[str, str, float | str]  # figure, sign, and a number, a word or another figure
SIGNS = {"<": operator.lt, ">": operator.gt, "=": operator.eq, "!=": operator.ne}
TONES = {"reproduced": "good", "there": "good", "partly": "fair", "not reproduced": "bad"}


@dataclass(frozen=True)
class Claim:
    """A claim, system, figure or wish of a paper, and what the project measures of it."""

    group: str
    paper: str  # 1999 | 2001
    where: str  # section, equation or figure
    statement: str
    result: str  # a sentence with names of figures in braces
    criteria: tuple[Criterion, ...] = ()  # it is reproduced where all hold
    verdict: Verdict = "not measured"  # without criteria
    link: str = ""  # the page that shows more

    def decided(self, figures: Mapping[str, Any]) -> Verdict:
        """Return the verdict that the measured figures give, or the claim's own without criteria."""
        if not self.criteria:
            return self.verdict
        if any(name not in figures for name, _, _ in self.criteria):
            return "not measured"
        return "reproduced" if holds(self.criteria, figures) else "not reproduced"

    def shown(self, figures: Mapping[str, Any]) -> dict[str, str]:
        """Return what a page shows of the claim."""
        verdict = self.decided(figures)
        return {
            "paper": self.paper, "where": self.where, "statement": self.statement,
            "result": filled(self.result, figures), "verdict": verdict, "tone": TONES.get(verdict, "plain"),
            "link": self.link,
        }  # fmt: skip


def holds(criteria: Iterable[Criterion], figures: Mapping[str, Any]) -> bool:
    """Return whether all criteria hold. A figure that is missing, or a word compared by size, satisfies none."""
    return all(_holds(figures.get(name), sign, figures.get(str(other), other)) for name, sign, other in criteria)


def _holds(one: Any, sign: str, other: Any) -> bool:
    if sign in "<>" and not (isinstance(one, int | float) and isinstance(other, int | float)):
        return False
    return one is not None and SIGNS[sign](one, other)


NAME = re.compile(r"\{([^{}:|]+)(?::([^{}|]+))?(?:\|([^{}]*))?\}")
UNKNOWN = "(not measured)"
FORMATS: dict[str, Callable[[Any], str]] = {
    "short": short, "short3": partial(short, digits=3), "duration": duration, "metres": metres, "joules": joules,
    "kilo": lambda value: short(value / 1e3, 3), "milli": lambda value: short(value * 1e3, 3),
}  # fmt: skip


def filled(text: str, figures: Mapping[str, Any]) -> str:
    """Return a text with its figures."""
    return NAME.sub(lambda place: _shown(figures, *place.groups()), text)


def markup(text: str, figures: Mapping[str, Any]) -> Markup:
    """Return HTML with its figures, which are escaped."""
    return Markup(NAME.sub(lambda place: escape(_shown(figures, *place.groups())), text))


def figure(value: float | str) -> str:
    """Return a figure in the default format: three digits, or all of a number from 1000 to a million."""
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else short(value, 3)


def _shown(figures: Mapping[str, Any], name: str, form: str | None, absent: str | None) -> str:
    value = figures.get(name)
    if value is None:
        return absent or (ABSENT if name in figures else UNKNOWN)
    if form is None or isinstance(value, str):
        return figure(value)
    return FORMATS[form](value) if form in FORMATS else format(value, form)


Block = dict[str, Any]
Figures = Mapping[str, Any]


@dataclass(frozen=True)
class Document:
    """A study's text; the module's docstring describes its blocks."""

    study: str
    page: str  # its file; studies of one file share a page
    title: str  # of the page
    name: str  # the section's anchor
    heading: str
    lead: str
    blocks: list[Block]
    place: int = 0  # on a shared page; the lowest stands first
    alone: bool = False  # it measures times, so that nothing else may run meanwhile
    fuller: bool = False  # a full report measures more (see reports.studies.study)
    stored: bool = False  # it presents tables of the source tree, for which nothing is run
    claim: list[dict[str, Any]] = field(default_factory=list)

    @property
    def section(self) -> Section:
        """The section that presents the study."""
        return Section(self.name, self.heading, self.context, self.lead, "document.html")

    def context(self, data: ReportData) -> dict[str, Any]:
        """Return what the template shows: nothing where the study was not measured."""
        facts = data.studies.get(self.study)
        return {"study": self.study, "shown": None if facts is None else self._shown(facts, data, self.blocks, {})}

    def claims(self) -> tuple[Claim, ...]:
        """Return every claim in the order of the page."""
        return tuple(Claim(**{**entry, "criteria": _criteria(entry, "criteria")}) for entry in self.claim)

    def _shown(self, facts: Measured, data: ReportData, blocks: list[Block], row: Figures) -> list[Block]:
        known = {name: value for facts in data.studies.values() for name, value in facts.figures.items()}
        figures = {**known, **row}  # of all studies: one may name those of another
        return [self._block(facts, data, b, figures) for b in blocks if holds(_criteria(b, "where"), figures)]

    def _block(self, facts: Measured, data: ReportData, block: Block, figures: Figures) -> Block:
        kind = next(key for key in (*KINDS, "claims", "each") if key in block)
        facts = data.studies.get(block["study"], Measured()) if "study" in block else facts
        layout = {"kind": kind, "layout": block.get("layout", "")}
        if kind == "claims":
            return layout | _claims(self.claims(), figures)
        if kind == "each":
            entries = facts.tables.get(block[kind], ()) if isinstance(block[kind], str) else block[kind]
            return layout | {"items": [self._item(facts, data, block, entry, figures) for entry in entries]}
        return layout | {"value": KINDS[kind](facts, block, figures)}

    def _item(self, facts: Measured, data: ReportData, block: Block, entry: Any, figures: Figures) -> Block:
        if isinstance(entry, str):
            block, entry = json.loads(json.dumps(block).replace("@", entry)), {}
        row = {**figures, **entry}
        title = filled(block.get("summary", ""), row)
        return {"title": title, "open": block.get("open", title) in title,
                "blocks": self._shown(facts, data, block["blocks"], row)}  # fmt: skip


def _criteria(entry: dict[str, Any], key: str) -> tuple[Criterion, ...]:
    return tuple((name, sign, other) for name, sign, other in entry.get(key, ()))


def _named[Value](held: Mapping[str, Value], pattern: str, figures: Figures) -> dict[str, tuple[str, Value]]:
    """Return name -> heading, value of what a pattern names, in its order."""
    form = re.compile(re.escape(filled(pattern, figures)).replace(r"\*", "(.*)"))
    met = {name: form.fullmatch(name) for name in held}
    return {name: ("".join(match.groups()), held[name]) for name, match in met.items() if match}


def _table(facts: Measured, block: Block, figures: Figures) -> list[dict[str, Any]]:
    """Return heading, head and rows of each table."""
    tables = []
    for title, rows in _named(facts.tables, block["table"], figures).values():
        columns = block.get("columns") or {name: "" for row in rows for name in row}
        cells = [_trimmed([_cell(name, text, {**figures, **row}) for name, text in columns.items()]) for row in rows]
        tables.append({"title": title, "head": [filled(name, figures) for name in columns], "rows": cells})
    return tables


def _trimmed(cells: list[str]) -> list[str]:
    """Return a row without empty cells at its end, into which the last one extends."""
    return _trimmed(cells[:-1]) if cells and not cells[-1] else cells


def _matrix(facts: Measured, block: Block, figures: Figures) -> list[dict[str, Any]]:
    columns = block["matrix"]
    rows = [
        [label, *(filled(text.replace("@", column), figures) for column in columns.values())]
        for label, text in block["rows"].items()
    ]
    return [{"title": "", "head": [block.get("corner", ""), *columns], "rows": rows}]


def _cell(name: str, text: str, row: Figures) -> str:
    """Return a cell by its text, or the column's own figure without one."""
    return filled(text, row) if text else ABSENT if row.get(name) is None else figure(row[name])


def _claims(claims: tuple[Claim, ...], figures: Figures) -> Block:
    groups: dict[str, list[dict[str, str]]] = {}
    for claim in claims:
        groups.setdefault(claim.group, []).append(claim.shown(figures))
    counted = Counter(row["verdict"] for rows in groups.values() for row in rows)
    return {"groups": groups, "counted": ", ".join(f"{number} {verdict}" for verdict, number in counted.most_common())}


def _each(kind: str, key: str, shown: Callable[[Any], Block]) -> Callable[[Measured, Block, Figures], list[Block]]:
    """Return what shows each fact of a kind that a block names."""
    return lambda facts, block, figures: [
        {"title": title, "label": name} | shown(value)
        for name, (title, value) in _named(getattr(facts, kind), block[key], figures).items()
    ]


def _overlay(facts: Measured, block: Block, figures: Figures) -> list[dict[str, Any]]:
    lines = dict(_named(facts.curves, block["overlay"], figures).values())
    return [{"title": "", "label": filled(block["overlay"], figures), "plot": overlay(lines)}] if lines else []


def _text(key: str) -> Callable[[Measured, Block, Figures], Any]:
    return lambda facts, block, figures: markup(block[key], figures)


KINDS: dict[str, Callable[[Measured, Block, Figures], Any]] = {
    **{key: _text(key) for key in ("heading", "title", "text", "note")},
    **{key: _each("films", key, lambda film: {"film": film}) for key in ("films", "pictures")},
    "plots": _each("curves", "plots", lambda line: {"plot": overlay({"": line})}),
    "outlines": _each("tables", "outlines", lambda rows: {"rows": rows}),
    "table": _table, "matrix": _matrix, "overlay": _overlay,
}  # fmt: skip
