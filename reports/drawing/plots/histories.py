"""Quantities over time in one small plot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from reports.drawing.plots.figure import FLOOR, Figure, new_figure, to_data
from reports.drawing.plots.palette import COLOURS, DASHES
from reports.facts.curves import Curves

HEIGHT = 360  # pixels


def histories(curves: Curves) -> dict[str, Any]:
    """Return a figure's data with a line for each name."""
    return overlay({"": curves})


def overlay(curves: Mapping[str, Curves]) -> dict[str, Any]:
    """Return the data of one figure with the lines of all curves, on the axes of the first."""
    first = next(iter(curves.values()))
    figure = new_figure(first.x_label, first.y_label, x_log=first.x_log, y_log=first.log, height=HEIGHT)
    lines = [(title, name, c, line) for title, c in curves.items() for name, line in c.lines.items()]
    for k, (title, name, c, line) in enumerate(lines):
        shown = [max(abs(value), FLOOR) for value in line] if c.log else line
        label = name if not title else title if len(c.lines) == 1 else f"{title}: {name}"
        add_line(figure, k, label, c.x, shown, c.marks)
    return to_data(figure)


def add_line(figure: Figure, k: int, name: str, x, y, mode: str = "lines") -> None:
    """Add the k-th line of a plot."""
    style = {"color": COLOURS[k % len(COLOURS)], "dash": DASHES[k // len(COLOURS) % len(DASHES)], "width": 2}
    figure.add_scatter(x=list(x), y=list(y), mode=mode, name=name, line=style)
