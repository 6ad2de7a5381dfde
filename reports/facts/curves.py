"""Lines over a common axis and films of a motion, as plain data, and the plots that they make."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cross_checks import engines
from cross_checks.records.plots import COLOURS, FLOOR, SYMBOLS, Style, new_figure, style_of, to_data
from mbs_ref import Scene, Trajectory
from reports.film.files import filmstrip, gif

MOST_POINTS = 201  # of a line
DIGITS = 6
HEIGHT = 360  # pixels of a plot

Value = int | float | str | None
Row = Mapping[str, Value]  # of a table, by column


@dataclass(frozen=True)
class Curves:
    """What a small plot shows; every line has the x of all."""

    x: tuple[float | str, ...]
    lines: Mapping[str, tuple[float | None, ...]]  # None is a gap
    y_label: str
    x_label: str = "t, s"
    log: bool = False
    x_log: bool = False
    marks: str = "lines"  # lines | markers | lines+markers
    equal: bool = False  # whether both axes have one scale


@dataclass(frozen=True)
class Film:
    """A motion in pictures: base64 of a GIF that plays it, and of a PNG strip of moments."""

    gif: str
    strip: str


@dataclass(frozen=True)
class Measured:
    """What a study measures, by name: SI numbers and words, rows of tables, curves and films."""

    figures: dict[str, Value] = field(default_factory=dict)
    tables: dict[str, tuple[Row, ...]] = field(default_factory=dict)  # each row by column
    curves: dict[str, Curves] = field(default_factory=dict)
    films: dict[str, Film] = field(default_factory=dict)


def curves(x: np.ndarray, lines: Mapping[str, np.ndarray], y_label: str, log: bool = False) -> Curves:
    """Return lines thinned to MOST_POINTS and rounded to DIGITS; ValueError where one is not finite."""
    every = max(1, (len(x) - 1) // (MOST_POINTS - 1))
    return Curves(plain(x[::every]), {name: plain(line[::every]) for name, line in lines.items()}, y_label, log=log)


def plain(values: Any) -> tuple[float, ...]:
    """Return rounded floats; ValueError where one is not finite."""
    result = np.asarray(values, dtype=float)
    if not np.all(np.isfinite(result)):
        raise ValueError("a curve holds a value that is not finite")
    return tuple(float(f"{value:.{DIGITS}g}") for value in result)


def film(scene: Scene, path: Trajectory, every: int) -> Film:
    """Return the pictures of a motion, every so many samples."""
    few = path.at(slice(None, None, every))
    return Film(*(base64.b64encode(picture).decode() for picture in (gif(scene, few), filmstrip(scene, few))))


def overlay(curves: Mapping[str, Curves]) -> dict[str, Any]:
    """Return the data of one figure with the lines of all curves, on the axes of the first."""
    first = next(iter(curves.values()))
    figure = new_figure(first.x_label, first.y_label, x_log=first.x_log, y_log=first.log, height=HEIGHT)
    if first.equal:
        figure.update_yaxes(scaleanchor="x")
    lines = [(title, name, c, line) for title, c in curves.items() for name, line in c.lines.items()]
    for k, (title, name, c, line) in enumerate(lines):
        shown = [None if value is None else max(abs(value), FLOOR) if c.log else value for value in line]
        label = name if not title else title if len(c.lines) == 1 else f"{title}: {name}"
        own = style_of(name) if name in engines.names() else Style(COLOURS[k % len(COLOURS)], SYMBOLS[k % len(SYMBOLS)])
        marker = {"symbol": own.symbol, "size": 8, "color": own.colour}
        figure.add_scatter(x=list(c.x), y=shown, mode=c.marks, name=label, marker=marker,
                           line={"color": own.colour, "width": 2})  # fmt: skip
    return to_data(figure)
