"""What accuracy costs on a scene, engine by engine: the plot of a scene's entry in the gallery."""

from __future__ import annotations

from pathlib import Path

from cross_checks import engines
from cross_checks.judge.cell import refused
from cross_checks.judge.runs import Runs
from cross_checks.judge.search import search
from cross_checks.records.record import Record
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from reports.drawing.figures import work_precision
from reports.facts.cheapest import usable

TARGETS = (1e-3, 1e-6)  # over the scene's scales
SCRIPT = "directory"  # plotly's script stands once beside the plots


def write_trade(runs: Runs, scene: Scene, target: Path) -> str:
    """Write the plot of every installed engine's own choice of method; return an empty text, or why there is none."""
    truth = runs.truth(scene)
    if isinstance(truth, NoTruth):
        return truth.reason
    records = [record for name in entrants() for record in _searched(runs, scene, name, truth)]
    if not any(usable(record) for record in records):
        return "no engine's own choice of method reaches the end"
    work_precision(records).write_html(target, include_plotlyjs=SCRIPT)
    return ""


def entrants() -> list[str]:
    """Return the engines that are asked."""
    return engines.names()


def _searched(runs: Runs, scene: Scene, name: str, truth: Truth) -> list[Record]:
    """Return the runs that the search makes with an engine's default method; none where it is missing or refuses."""
    try:
        method = engines.get(name).method(None)
    except engines.EngineMissing:
        return []
    if refused(scene, name, method)[1]:
        return []
    return list(search(runs, scene, name, method, truth, TARGETS)[0].records.values())
