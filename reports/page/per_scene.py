"""One figure a scene, where the scene has the data for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from reports.facts.report_data import ReportData


def per_scene(data: ReportData, plot: Callable[..., dict[str, Any] | None]) -> dict[str, dict[str, Any]]:
    """Return scene -> figure for every scene that `plot` can draw."""
    figures = {scene: plot(data.of_scene(scene)) for scene in data.scenes}
    return {scene: figure for scene, figure in figures.items() if figure}
