"""Sentences with figures, and the criteria by which measured figures decide claims.

{name} in a text stands for a measured figure, {name:format} for one in a given format; {name:format|words} shows the
words where the figure is None. A format is one of FORMATS or Python's own.
"""

import operator
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from markupsafe import Markup, escape

from cross_checks.records.numbers import ABSENT, duration, joules, metres, short

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

    @property
    def names(self) -> set[str]:
        """Return the names of the figures that the result and the criteria use."""
        return {*(place[1] for place in NAME.finditer(self.result)), *(name for name, _, _ in self.criteria)}


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
