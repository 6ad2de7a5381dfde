"""A figure for each scene whose runs hold the data: convergence, compliance and error, energy, and time split."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from reports.drawing.plots.convergence import convergence
from reports.drawing.plots.history import compliance, energy, error_history
from reports.drawing.plots.time_split import time_split
from reports.drawing.section import Section
from reports.facts.report_data import ReportData


def _per_scene(data: ReportData, plot: Callable[..., dict[str, Any] | None]) -> dict[str, dict[str, Any]]:
    """Return scene -> figure for every scene that `plot` can draw."""
    figures = {scene: plot(data.of_scene(scene)) for scene in data.scenes}
    return {scene: figure for scene, figure in figures.items() if figure}


def _convergence(data: ReportData) -> dict[str, Any]:
    orders = {(c.engine, c.method): c.documented_order for c in data.cells if c.documented_order}
    plots = {key: partial(convergence, over=over, orders=orders)
             for key, over in (("by_step", "step"), ("by_tolerance", "rtol"))}  # fmt: skip
    return {key: _per_scene(data, plot) for key, plot in plots.items()}


SECTIONS = (
    Section(
        "compliance", "Compliance over time",
        "How far the joints gape while the mechanism moves, measured by one code from every engine's poses; and beside "
        "it the distance from the truth, because closed joints do not prove a right answer.",
        lambda data: {"compliance": _per_scene(data, compliance), "error": _per_scene(data, error_history)},
    ),
    Section(
        "energy", "Energy drift",
        "Energy that the integration created or lost, work of drives counted. Small drift alone does not prove "
        "accuracy.",
        lambda data: {"plots": _per_scene(data, energy)},
    ),
    Section(
        "convergence", "Convergence order",
        "A method of order p gains a factor 2^p when its step is halved: its line runs parallel to that order's "
        "triangle. A line that goes flat has met its limit: roundoff, or a wrong answer.",
        _convergence,
    ),
    Section(
        "time_split", "Time split",
        "Building the model, the first call and the loop apart, at each engine's cheapest setting within 1e-6 of the "
        "scene.",
        lambda data: {"plots": _per_scene(data, time_split)},
    ),
)  # fmt: skip
