"""Quantities over time in one small plot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from reports.page.plots.figure import FLOOR, new_figure, to_data
from reports.page.plots.palette import COLOURS, DASHES

HEIGHT = 360  # pixels
MOST_POINTS = 201  # of a line


def histories(times: np.ndarray, values: Mapping[str, np.ndarray], label: str, log: bool = False) -> dict[str, Any]:
    """Return a figure's data with a line for each name; every line's times are `times` (n_t,), s."""
    figure = new_figure("t, s", label, x_log=False, y_log=log)
    figure.update_layout(height=HEIGHT)
    every = max(1, (len(times) - 1) // (MOST_POINTS - 1))
    for k, (name, history) in enumerate(values.items()):
        shown = np.maximum(np.abs(history), FLOOR) if log else np.asarray(history)
        add_line(figure, k, name, times[::every], shown[::every])
    return to_data(figure)


def add_line(figure, k: int, name: str, x: np.ndarray, y: np.ndarray) -> None:
    """Add the k-th line of a plot."""
    style = {"color": COLOURS[k % len(COLOURS)], "dash": DASHES[k // len(COLOURS) % len(DASHES)], "width": 2}
    figure.add_scatter(x=x.tolist(), y=[float(f"{v:.6g}") for v in y], mode="lines", name=name, line=style)
