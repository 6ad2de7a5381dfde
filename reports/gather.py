"""What the report shows, asked of the store of runs: what it lacks is made on all cores, then timed alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from cross_checks import engines
from cross_checks.extremes import named
from cross_checks.extremes.cell import Cell as ExtremeCell
from cross_checks.extremes.cell import read as read_cells
from cross_checks.extremes.run import matrix
from cross_checks.judge.answers import questions
from cross_checks.judge.capabilities import Capability, capabilities
from cross_checks.judge.cell import tasks
from cross_checks.prices.timing import timed_all
from cross_checks.records.naming import code_of, digest_of
from cross_checks.records.store import Store
from mbs_ref import scenes
from mbs_ref.scene import Scene
from reports.facts.cheapest import contenders
from reports.facts.compiling import compile_kernels
from reports.facts.environment import environment
from reports.facts.kept import (
    Stored,
    engine_versions,
    keep,
    recall,
    remembered,
    settled_answers,
    stored_answers,
    truth_key,
)
from reports.facts.report_data import ReportData
from reports.facts.truth_facts import TruthFacts, truth_facts
from reports.studies.study import Progress, every, measure_all, stored

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
QUICK = (("pendulum", {}), ("pendulum_chain", {"links": 3}), ("n_four_bar", {"loops": 1}))
FEW_EXTREMES = ("stiff-spring-quiet", "crash-pulse", "overflow")


def gather(
    store: Store, quick: bool = False, progress: Progress | None = None, extremes_files: Sequence[Path] = (),
    again: bool = False,
) -> Iterator[ReportData]:  # fmt: skip
    """Yield the cells, runs and studies of the default scenes (few of them when quick), after each stage what there is.

    Effort is bounded by the work that a search may do, never by a clock. `again` times anew what the store has timed.
    `incomplete` says what is still being made; after Ctrl-C, what was interrupted.
    """
    report = progress or _silent
    chosen = chosen_scenes(quick)
    data = ReportData((), (), environment=environment(), quick=quick, studies=stored())
    stages = STAGES[:-1] if quick else STAGES
    for (_, stage), (following, _) in zip(stages, (*stages[1:], ("", None)), strict=True):
        data = stage(store, chosen, data, report, extremes_files, again)
        if data.incomplete.startswith(INTERRUPTED) or not following:
            break
        yield replace(data, incomplete=f"still being made: {following}")
    report(1, 1, "writing the page")
    yield data


INTERRUPTED = "interrupted"


def chosen_scenes(quick: bool = False) -> dict[str, Scene]:
    """Return the scenes of the report by their labels."""
    made = [scenes.make(name, **parameters) for name, parameters in (QUICK if quick else SCENES)]
    return {scenes.label(scene.name, scene.parameters): scene for scene in made}


@contextmanager
def _interruptible(told: list[str], what: Callable[[], str]) -> Iterator[None]:
    """Turn Ctrl-C into a sentence."""
    try:
        yield
    except KeyboardInterrupt:
        told.append(f"{INTERRUPTED} after {what()}")


def _judged(store: Store, chosen: dict[str, Scene], data: ReportData, report: Progress, *_: Any) -> ReportData:
    """Judge every method on every scene; unfinished ones are left out after Ctrl-C."""
    asked = questions(list(chosen.values()), tasks(engines.names()))
    found = stored_answers(store, asked)
    missing = [question for question in asked if question not in found]
    told: list[str] = []
    truths: dict[str, TruthFacts] = {}
    with _interruptible(told, lambda: f"{len(found)} of {len(asked)} cells"):
        if missing:
            compile_kernels(store, report)
            for answer in settled_answers(store, missing, report):
                if answer.truth is not None and answer.cell.label not in truths:
                    truths[answer.cell.label] = truth_facts(answer.cell.label, answer.question.scene, answer.truth)
                    keep(store, truth_key(answer.question.scene), TruthFacts, truths[answer.cell.label])
                found[answer.question] = Stored(answer.cell, answer.records)
    there = [found[question] for question in asked if question in found]
    return replace(
        data, cells=tuple(answer.cell for answer in there), incomplete="; ".join(told),
        records=tuple(record for answer in there for record in answer.records),
    )  # fmt: skip


def _timed(
    store: Store, chosen: dict[str, Scene], data: ReportData, report: Progress, _: Any, again: bool
) -> ReportData:
    """Time what is ranked, alone."""
    told: list[str] = []
    found: dict[int, Any] = {}
    with _interruptible(told, lambda: "the accuracy runs, before all was timed"):
        found = timed_all(store, contenders(data), report, again)
    records = tuple(found.get(id(record), record) for record in data.records)
    return replace(data, records=records, incomplete="; ".join(told))


def _beyond(
    store: Store, chosen: dict[str, Scene], data: ReportData, report: Progress, extremes: Sequence[Path], _: Any
) -> ReportData:
    """Add what is asked of adapters and truths, and the extremes."""
    told: list[str] = []
    kept = [recall(store, truth_key(scene), TruthFacts) for scene in chosen.values()]
    data = replace(data, truths=tuple(facts for facts in kept if facts is not None))
    key = digest_of(
        ["capabilities", engine_versions(), _adapters(), list(chosen), code_of("cross_checks.judge.capabilities")]
    )
    able = remembered(store, key, tuple[Capability, ...], lambda: capabilities(chosen))  # type: ignore[type-var]
    data = replace(data, capabilities=able)
    with _interruptible(told, lambda: "the timed runs, before the extremes"):
        data = replace(data, extremes=extreme_cells(store, extremes, data.quick, report))
    return replace(data, incomplete="; ".join(told))


def _adapters() -> list[str]:
    found = []
    for name in engines.names():
        try:
            found.append(code_of(type(engines.get(name)).__module__))
        except engines.EngineMissing:
            found.append("missing")
    return found


def extreme_cells(store: Store, kept: Sequence[Path], quick: bool, report: Progress) -> tuple[ExtremeCell, ...]:
    """Return the cells kept in files, full ones before quick ones; without a file those of a few extremes."""
    if kept:
        cells = sorted((cell for file in kept for cell in read_cells(file)[0]), key=lambda cell: cell.full)
        return tuple({(c.extreme, c.engine, c.method): c for c in cells}.values())
    if quick:
        return ()
    few = [named(name) for name in FEW_EXTREMES]
    key = digest_of(
        ["extremes", list(FEW_EXTREMES), engine_versions(), _adapters(), code_of("cross_checks.extremes.run")]
    )
    kind = tuple[ExtremeCell, ...]
    return remembered(store, key, kind, lambda: tuple(matrix(few, engines.names(), progress=report)))  # type: ignore[type-var]


def _studied(store: Store, chosen: dict[str, Scene], data: ReportData, report: Progress, *_: Any) -> ReportData:
    """Add the studies; one that fails costs its own page only."""
    told: list[str] = []
    found = dict(data.studies)
    with _interruptible(told, lambda: f"{len(found)} of {len(every())} studies"):
        told += measure_all(store, found, (engine_versions(), _adapters()), report)
    return replace(data, studies=found, incomplete="; ".join(told))


STAGES: tuple[tuple[str, Callable[..., ReportData]], ...] = (  # each with what a page without it still waits for
    ("verdicts", _judged), ("times taken alone", _timed), ("capabilities and extremes", _beyond), ("studies", _studied),
)  # fmt: skip


def _silent(done: int, total: int, what: str) -> None:
    pass
