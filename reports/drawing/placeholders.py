"""Sentences with figures: {name} in a text stands for a measured figure, {name:format} for one in a given format.

{name:format|words} shows the words where the figure is None. A format is one of FORMATS or Python's own.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from markupsafe import Markup, escape

from reports.drawing.numbers import ABSENT, duration, joules, metres, short

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
