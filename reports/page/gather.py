"""Run what the report shows: every engine's methods on the default scenes, judged and timed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from benchmarks.sweep import sweep
from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.extremes import named
from cross_checks.extremes.cell import Cell as ExtremeCell
from cross_checks.extremes.cell import read as read_cells
from cross_checks.extremes.run import matrix
from cross_checks.isolation.parent import Caller, Isolated, Lost
from cross_checks.judge.matrix import CELL_TIMEOUT, judged, missing
from cross_checks.records.record import Record
from mbs_ref import scenes
from mbs_ref.scene import Scene
from reports.page.capability import capabilities
from reports.page.environment import environment
from reports.page.numbers import finite
from reports.page.report_data import Cell, ReportData, scene_label
from reports.page.truth_facts import truth_facts
from reports.studies.androids import measure as androids
from reports.studies.contact import measure as contact
from reports.studies.crashes.measure import crashes
from reports.studies.sky import measure as sky
from reports.studies.space import measure as space

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
    ("torque_free_top", {"turns": 10.0}),
    ("heavy_top", {}),
    ("spatial_chain", {"links": 10}),
    ("spatial_n_four_bar", {"loops": 2}),
    ("bricard", {}),
    ("kepler", {"eccentricity": 0.9}),
    ("solar_system", {"model": "newton"}),
    ("satellite", {}),
)
RUN_TIME = 125.0  # s for all runs, so that the report with its compilation stays within five minutes on two cores
QUICK_TIME = 25.0  # s, for a first look
LEAST_SHARE = 0.2  # s for a method on a scene, however late it is
FEW_EXTREMES = ("stiff-spring-quiet", "crash-pulse", "overflow")
EXTREME_TIME = 20.0  # s
PARTS: dict[str, Callable[[], Any]] = {  # what ReportData holds beside the cells and sweeps of the default scenes
    "space": space.measure, "sky": sky.measure, "contact": contact.measure, "crashes": crashes,
    "androids": androids.measure,
}  # fmt: skip
PART_TIMEOUT = 300.0  # s, compilation included
QUICK = (("pendulum", {}), ("pendulum_chain", {"links": 3}), ("n_four_bar", {"loops": 1}))


def gather(
    quick: bool = False, progress: Progress | None = None, extremes_file: Path | None = None
) -> ReportData:
    """Return cells and records of the default scenes (few of them when quick), within RUN_TIME (QUICK_TIME).

    After Ctrl-C, what there is so far, with a sentence in `incomplete`.
    """
    begun = time.perf_counter()
    made = [scenes.make(name, **parameters) for name, parameters in (QUICK if quick else SCENES)]
    chosen = {scene_label(scene.name, scene.parameters): scene for scene in made}
    report = progress or _silent
    tasks = [(*item, name, method) for item in chosen.items() for name in engines.names() for method in _methods(name)]
    cells: list[Cell] = []
    records: list[Record] = []
    incomplete, beyond = "", dict[str, Any]()
    try:
        with Isolated(CELL_TIMEOUT) as call:
            _warm_up(next(iter(chosen.values())), report, call)
            _run(tasks, begun, cells, records, report, call, QUICK_TIME if quick else RUN_TIME)
        beyond = {"truths": truth_facts(chosen), "extremes": extreme_cells(extremes_file, quick)}
        incomplete = "" if quick else measure_parts(beyond, report)
    except KeyboardInterrupt:
        incomplete = f"interrupted after {len(cells)} of {len(tasks)} cells"
    report(len(tasks), len(tasks), "writing the page")
    seconds = time.perf_counter() - begun
    facts = environment() | {"time of the runs": f"{seconds:.0f} s"}
    return ReportData(
        tuple(cells), tuple(records), capabilities(chosen), facts, _orders(), quick, seconds=seconds,
        incomplete=incomplete, **beyond,
    )  # fmt: skip


def measure_parts(found: dict[str, Any], report: Progress) -> str:
    """Add what PARTS measure to `found`; return which failed and why. One that fails costs its own section only."""
    failed = []
    with Isolated(PART_TIMEOUT) as call:
        for done, (name, measure) in enumerate(PARTS.items()):
            report(done, len(PARTS), f"section {name}")
            try:
                found[name] = call(measure)
            except (Lost, RuntimeError, ValueError, ArithmeticError) as error:
                failed.append(f"section {name}: {error}")
    return "; ".join(failed)


def _run(
    tasks, begun: float, cells: list[Cell], records: list[Record], report: Progress, call: Caller, run_time: float
) -> None:
    """Add each task's cell and records as soon as they are there."""
    for done, (label, scene, engine, method) in enumerate(tasks):
        report(done, len(tasks), f"{label}, {engine} {method.name if method else 'is not installed'}")
        if method is None:
            cells.append(_cell(label, missing(scene, engine)))
            continue
        # time that earlier tasks left unused goes to the later ones
        share = max(LEAST_SHARE, (run_time - time.perf_counter() + begun) / (len(tasks) - done))
        cells.append(_cell(label, judged(scene, engine, method, share / 2, call)))
        records.extend(_timed(scene, engine, method, share / 2, call))


def extreme_cells(kept: Path | None, quick: bool) -> tuple[ExtremeCell, ...]:
    """Return the cells kept in a file, full ones first; without a file a few, within EXTREME_TIME."""
    if kept is not None and kept.is_file():
        found = {(c.extreme, c.engine, c.method): c for c in sorted(read_cells(kept)[0], key=lambda c: c.full)}
        return tuple(found.values())
    if quick:
        return ()
    cells, begun = [], time.perf_counter()
    for cell in matrix([named(name) for name in FEW_EXTREMES], engines.names()):
        cells.append(cell)
        if time.perf_counter() - begun > EXTREME_TIME:
            break
    return tuple(cells)


def _warm_up(scene: Scene, report: Progress, call: Caller) -> None:
    """Run every method once, so that compiling and loading eat no method's share of the time."""
    for name in engines.names():
        report(0, 1, f"compiling and loading {name}")
        for method in _methods(name):
            if method is not None:
                judged(scene, name, method, 0.0, call)


def _timed(scene: Scene, engine: str, method: Method, budget_s: float, call: Caller) -> Iterator[Record]:
    """Yield the method's sweep until its share of the report's time is spent."""
    begun = time.perf_counter()
    for record in sweep(scene, [engine], [method.name], call=call):
        yield record
        if time.perf_counter() - begun > budget_s:
            return


def _methods(engine: str) -> tuple[Method | None, ...]:
    """Return the engine's methods, or a single None where it is not installed."""
    try:
        return engines.get(engine).methods()
    except engines.EngineMissing:
        return (None,)


def _silent(done: int, total: int, what: str) -> None:
    pass


def _cell(label: str, found) -> Cell:
    """Return the judge's cell under the scene's label, with finite numbers or None."""
    return Cell(label, found.engine, found.method or "any method", found.verdict, found.reason or "",
                finite(found.error), finite(found.compliance), finite(found.order))  # fmt: skip


def _orders() -> dict[tuple[str, str], int]:
    """Return the documented order of every fixed-step method of the engines installed."""
    every = [(name, method) for name in engines.names() for method in _methods(name) if method is not None]
    return {(name, m.name): m.order for name, m in every if m.kind == "fixed" and m.order}
