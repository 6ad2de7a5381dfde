"""Run what the report shows: every engine's methods on the default scenes, judged and timed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from benchmarks.sweep import sweep
from cross_checks.matrix import check

from cross_checks import engines
from mbs_ref import scenes
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
QUICK = (("pendulum", {}), ("pendulum_chain", {"links": 3}), ("n_four_bar", {"loops": 1}))


def gather(quick: bool = False, progress: Progress | None = None) -> ReportData:
    """Return cells and records of the default scenes (few of them when quick), one engine at a time."""
    begun = time.perf_counter()
    made = [scenes.make(name, **parameters) for name, parameters in (QUICK if quick else SCENES)]
    chosen = {scene_label(scene.name, scene.parameters): scene for scene in made}
    report = progress or _silent
    cells, records = [], []
    for k, (label, scene) in enumerate(chosen.items()):
        report(2 * k, 2 * len(chosen), f"check {label}")
        cells += [_cell(label, found) for found in check([scene], engines.names())]
        report(2 * k + 1, 2 * len(chosen), f"sweep {label}")
        records += list(sweep(scene, engines.names()))
    seconds = time.perf_counter() - begun
    facts = environment() | {"time of the runs": f"{seconds:.0f} s"}
    return ReportData(tuple(cells), tuple(records), capabilities(chosen), facts, _orders(), quick, seconds)


def _silent(done: int, total: int, what: str) -> None:
    pass


def _cell(label: str, found) -> Cell:
    """Return the judge's cell under the scene's label, with finite numbers or None."""
    return Cell(label, found.engine, found.method or "any method", found.verdict, found.reason or "",
                finite(found.error), finite(found.compliance), finite(found.order))  # fmt: skip


def _orders() -> dict[tuple[str, str], int]:
    """Return the documented order of every fixed-step method of the engines installed."""
    found: dict[tuple[str, str], int] = {}
    for name in engines.names():
        try:
            methods = engines.get(name).methods()
        except engines.EngineMissing:
            continue
        found |= {(name, m.name): m.order for m in methods if m.kind == "fixed" and m.order}
    return found
