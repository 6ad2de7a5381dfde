"""Run what the report shows: every engine's methods on the default scenes, judged and timed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

from benchmarks.sweep import sweep
from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.matrix import check
from cross_checks.record import Record
from mbs_ref import scenes
from mbs_ref.scene import Scene
from reports.page.capability import capabilities
from reports.page.environment import environment
from reports.page.numbers import finite
from reports.page.report_data import Cell, ReportData, scene_label

Progress = Callable[[int, int, str], None]  # done, total, what comes next

SCENES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("pendulum", {}),
    ("double_pendulum", {}),
    ("pendulum_chain", {"links": 3}),
    ("pendulum_chain", {"links": 10}),
    ("n_four_bar", {"loops": 1}),
    ("n_four_bar", {"loops": 2}),
    ("slider_crank", {}),
    ("driven_pendulum", {}),
    ("spring_pendulum", {}),
)
CHECK_BUDGET = 1.0  # s of one cell's wall time; the report as a whole stays within five minutes on two cores
SWEEP_BUDGET = 1.0  # s of one method's wall time on one scene, likewise
QUICK = (("pendulum", {}), ("pendulum_chain", {"links": 3}), ("n_four_bar", {"loops": 1}))


def gather(quick: bool = False, progress: Progress | None = None) -> ReportData:
    """Return cells and records of the default scenes (few of them when quick), one engine at a time."""
    begun = time.perf_counter()
    made = [scenes.make(name, **parameters) for name, parameters in (QUICK if quick else SCENES)]
    chosen = {scene_label(scene.name, scene.parameters): scene for scene in made}
    report = progress or _silent
    pairs = [(label, scene, name) for label, scene in chosen.items() for name in engines.names()]
    cells, records = [], []
    for done, (label, scene, name) in enumerate(pairs):
        report(done, len(pairs), f"{label}, {name}")
        cells += [_cell(label, found) for found in check([scene], [name], budget_s=CHECK_BUDGET)]
        records += [record for method in _methods(name) for record in _timed(scene, name, method)]
    report(len(pairs), len(pairs), "writing the page")
    seconds = time.perf_counter() - begun
    facts = environment() | {"time of the runs": f"{seconds:.0f} s"}
    return ReportData(tuple(cells), tuple(records), capabilities(chosen), facts, _orders(), quick, seconds)


def _timed(scene: Scene, engine: str, method: Method) -> Iterator[Record]:
    """Yield the method's sweep until its share of the report's time is spent."""
    begun = time.perf_counter()
    for record in sweep(scene, [engine], [method.name]):
        yield record
        if time.perf_counter() - begun > SWEEP_BUDGET:
            return


def _methods(engine: str) -> tuple[Method, ...]:
    try:
        return engines.get(engine).methods()
    except engines.EngineMissing:
        return ()


def _silent(done: int, total: int, what: str) -> None:
    pass


def _cell(label: str, found) -> Cell:
    """Return the judge's cell under the scene's label, with finite numbers or None."""
    return Cell(label, found.engine, found.method or "any method", found.verdict, found.reason or "",
                finite(found.error), finite(found.compliance), finite(found.order))  # fmt: skip


def _orders() -> dict[tuple[str, str], int]:
    """Return the documented order of every fixed-step method of the engines installed."""
    every = [(name, method) for name in engines.names() for method in _methods(name)]
    return {(name, m.name): m.order for name, m in every if m.kind == "fixed" and m.order}
