"""Significant figures of every body against the physics in the model."""

from __future__ import annotations

from typing import Any

from cross_checks.records.plots.plot import COLOURS, DASHES, new_figure, to_data


def sky_ladder(levels: list[str], figures: list[dict[str, float]]) -> dict[str, Any]:
    """Return the figure: levels across, figures up, a line a body."""
    figure = new_figure("physics in the model", "significant figures", x_log=False, y_log=False)
    for k, body in enumerate(dict.fromkeys(name for found in figures for name in found)):
        known = [(level, found[body]) for level, found in zip(levels, figures, strict=True) if body in found]
        style = {"color": COLOURS[k % len(COLOURS)], "dash": DASHES[k // len(COLOURS)], "width": 2}
        x, y = [level for level, _ in known], [value for _, value in known]
        figure.add_scatter(x=x, y=y, mode="lines+markers", name=body, line=style)
    return to_data(figure)
