"""One colour an engine and one marker and dash a method, the same in every plot."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from cross_checks.records.record import Record

# Okabe and Ito's colour-blind safe set, shifted to hold 3:1 contrast on white and on near-black alike
COLOURS = ("#2b7bd6", "#d97706", "#0f9d70", "#c0569b", "#8a6fd1", "#2a9fb5", "#a58a12", "#c8524a")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross", "star", "hexagon", "triangle-down", "pentagon")
DASHES = ("solid", "dash", "dot", "dashdot")


@dataclass(frozen=True)
class Style:
    """How a method of an engine is drawn."""

    colour: str
    symbol: str
    dash: str


def colours(engines: Iterable[str]) -> dict[str, str]:
    """Return the colour of each engine; the order given decides."""
    return {name: COLOURS[k % len(COLOURS)] for k, name in enumerate(engines)}


def styles(records: Iterable[Record], engines: list[str]) -> dict[tuple[str, str], Style]:
    """Return the style of each (engine, method) met in the records."""
    chosen: dict[tuple[str, str], Style] = {}
    colour = colours(engines)
    for engine in engines:
        methods = dict.fromkeys(r.method for r in records if r.engine == engine)
        for k, method in enumerate(methods):
            chosen[engine, method] = Style(colour[engine], SYMBOLS[k % len(SYMBOLS)], DASHES[k % len(DASHES)])
    return chosen
