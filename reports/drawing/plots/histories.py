"""Quantities over time in one small plot."""

from __future__ import annotations

from typing import Any

from reports.drawing.plots.figure import FLOOR, Figure, new_figure, to_data
from reports.drawing.plots.palette import COLOURS, DASHES
from reports.facts.curves import Curves

HEIGHT = 360  # pixels


def histories(curves: Curves) -> dict[str, Any]:
    """Return a figure's data with a line for each name."""
    figure = new_figure(curves.x_label, curves.y_label, x_log=False, y_log=curves.log, height=HEIGHT)
    for k, (name, line) in enumerate(curves.lines.items()):
        shown = [max(abs(value), FLOOR) for value in line] if curves.log else line
        add_line(figure, k, name, curves.x, shown)
    return to_data(figure)


def add_line(figure: Figure, k: int, name: str, x, y) -> None:
    """Add the k-th line of a plot."""
    style = {"color": COLOURS[k % len(COLOURS)], "dash": DASHES[k // len(COLOURS) % len(DASHES)], "width": 2}
    figure.add_scatter(x=list(x), y=list(y), mode="lines", name=name, line=style)
