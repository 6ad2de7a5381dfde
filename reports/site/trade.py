"""What accuracy costs on a scene, engine by engine: the plot of a scene's entry in the gallery, at a bounded price."""

from __future__ import annotations

from pathlib import Path

from cross_checks import engines
from cross_checks.judge.cell import refused, truth_of
from cross_checks.judge.consensus import LEVELS
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import search
from cross_checks.records.record import Record
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from reports.drawing.figures import work_precision
from reports.facts.cheapest import usable

TARGETS = (1e-3, 1e-6)  # over the scene's scales
WORK = 50_000  # steps times bodies that a run of a plot may take
TRUTH_WORK = 300_000  # the same of a run that stands for a truth where none is certified
SCRIPT = "directory"  # plotly's script stands once beside the plots
BOUNDS = (
    f"A plot tries for errors of {TARGETS[0]:g} and {TARGETS[1]:g} with each engine's own choice of method, in runs of "
    f"at most {WORK:,} steps times bodies; `mbs-ref sweep NAME --plot NAME.html` draws every method without that bound."
)


def write_trade(runs: Runs, scene: Scene, target: Path) -> str:
    """Write the plot of every installed engine's own choice of method; return an empty text, or why there is none."""
    truth = _truth(runs, scene)
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


def _truth(runs: Runs, scene: Scene) -> Truth | NoTruth:
    """Return the certified truth, or what engines agree on where their finest runs are within the bound on work."""
    truth, steps, bodies = runs.truth(scene), round(1.0 / min(LEVELS[1]["fixed"])), len(scene.bodies)
    if not isinstance(truth, NoTruth) or steps * bodies <= TRUTH_WORK:
        return truth_of(runs, scene)
    price = f"{steps:,} steps of {bodies} bodies a run, more than {TRUTH_WORK:,} of both"
    return NoTruth(f"{truth.reason}, and what engines agree on would take {price}")


def _searched(runs: Runs, scene: Scene, name: str, truth: Truth) -> list[Record]:
    """Return the runs that the search makes with an engine's default method; none where it is missing or refuses."""
    try:
        method = engines.get(name).method(None)
    except engines.EngineMissing:
        return []
    if refused(scene, name, method)[1]:
        return []
    most = max(1, WORK // len(scene.bodies))
    return list(search(runs, scene, name, method, truth, TARGETS, most)[0].records.values())
