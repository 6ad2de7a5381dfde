"""The style of each engine, the same in every plot and table whichever engines are shown; a marker for each method."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from itertools import cycle
from zlib import crc32

from cross_checks import engines
from cross_checks.records.record import Record

# Okabe and Ito's colour-blind safe set, shifted to hold 3:1 contrast on white and on near-black alike
COLOURS = ("#2b7bd6", "#d97706", "#0f9d70", "#c0569b", "#8a6fd1", "#2a9fb5", "#a58a12", "#c8524a")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross", "star", "hexagon", "triangle-down", "pentagon")
MARKERS = (*SYMBOLS, *(f"{name}-open" for name in SYMBOLS))
DASHES = ("solid", "dash", "dot", "dashdot")
RADII = ("50%", "0", "50% 0", "0 50%")  # of a table's mark, one for each dash: circle, square, two leaves


@dataclass(frozen=True)
class Style:
    """How a method of an engine is drawn: colour and dash are the engine's, the symbol is the method's."""

    colour: str
    dash: str
    symbol: str = SYMBOLS[0]

    @property
    def mark(self) -> str:
        """The CSS of the engine's mark in a table."""
        return f"background:{self.colour};border-radius:{RADII[DASHES.index(self.dash)]}"


@cache
def style_of(engine: str) -> Style:
    """Return an engine's style, by its place among the project's adapters; of another's engine by its name alone."""
    known = [name for name in engines.names() if engines.is_ours(name)]
    place = known.index(engine) if engine in known else len(known) + crc32(engine.encode())
    return Style(COLOURS[place % len(COLOURS)], DASHES[place // len(COLOURS) % len(DASHES)])


def styles(records: Iterable[Record]) -> dict[tuple[str, str], Style]:
    """Return the style of each (engine, method) met in the records, the reference solver first."""
    listed = sorted({(r.engine, r.method) for r in records}, key=lambda pair: (pair[0] != engines.names()[0], pair))
    symbols = {engine: cycle(MARKERS) for engine, _ in listed}
    return {pair: replace(style_of(pair[0]), symbol=next(symbols[pair[0]])) for pair in listed}
