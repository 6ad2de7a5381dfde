"""What both papers claim, compute, draw and wish for: the entries of claims.toml, and which of them hold."""

from __future__ import annotations

import operator
import re
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from typing import Literal

from reports.drawing.numbers import short

Figures = dict[str, float | str]
Verdict = Literal["reproduced", "not reproduced", "partly", "there", "not attempted", "not measured"]
NAME = re.compile(r"\{([\w.\-]+)\}")  # of a figure in a sentence
UNKNOWN = "(not measured)"
SIGNS = {"<": operator.lt, ">": operator.gt, "=": operator.eq, "!=": operator.ne}


@dataclass(frozen=True)
class Claim:
    """One claim, system, figure or wish of a paper."""

    group: str
    paper: str  # 1999 | 2001
    where: str  # section, equation or figure
    said: str
    found: str  # with names of figures in braces
    stands: tuple[tuple[str, str, float | str], ...] = ()  # figure, sign, number, word or another figure
    verdict: Verdict = "not measured"  # where no figure decides
    link: str = ""  # the page that shows more

    def judged(self, figures: Figures) -> Verdict:
        """Return the verdict that the measured figures give; the claim's own where none decides."""
        if not self.stands:
            return self.verdict
        if any(_value(figures, name) is None for name, _, _ in self.stands):
            return "not measured"
        return "reproduced" if all(_holds(figures, *line) for line in self.stands) else "not reproduced"

    def told(self, figures: Figures) -> str:
        """Return what we find, with its figures."""
        return NAME.sub(lambda name: _shown(figures.get(name[1])), self.found)

    @property
    def named(self) -> set[str]:
        """The figures that it asks for."""
        return {*NAME.findall(self.found), *(name for name, _, _ in self.stands)}


def claims() -> tuple[Claim, ...]:
    """Return every claim in the order of the page."""
    entries = tomllib.loads((files("reports.studies.papers") / "claims.toml").read_text(encoding="utf-8"))["claim"]
    return tuple(Claim(**entry | {"stands": tuple(map(tuple, entry.get("stands", ())))}) for entry in entries)


def _value(figures: Figures, name: float | str) -> float | str | None:
    """Return a figure by its name; a number as it is."""
    return figures.get(name) if isinstance(name, str) else name


def _holds(figures: Figures, name: str, sign: str, other: float | str) -> bool:
    one, known = figures[name], _value(figures, other)
    two = other if known is None else known
    if sign in "<>" and not (isinstance(one, int | float) and isinstance(two, int | float)):
        return False  # a run that stopped left a sentence in place of a number
    return SIGNS[sign](one, two)


def _shown(value: float | str | None) -> str:
    if value is None or isinstance(value, str):
        return value or UNKNOWN
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else short(value, 3)
