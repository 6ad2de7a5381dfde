"""The validation matrix: every scene by every engine by every method, each cell a verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from cross_checks import engines as registry
from cross_checks.engine import Method
from cross_checks.isolation.parent import Caller, Lost, direct
from cross_checks.judge import ladder
from cross_checks.judge.one_run import MISSING, judged_run
from cross_checks.judge.verdict import AGREEMENT, Rung, Verdict, is_telling, judge, telling
from cross_checks.metrics.observed_order import observed_order
from cross_checks.metrics.pose_error import distance
from cross_checks.records.record import Record
from cross_checks.truth import NoTruth
from cross_checks.truths import seek_truth
from mbs_ref.scene import Scene
from mbs_ref.scene.units import unit_length
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory

CELL_TIMEOUT = 600.0  # s for one cell in a process of its own, compilation on a busy machine included
BUDGET = 2.0  # s of wall time after which a cell climbs no further
PATIENCE = 5.0  # budgets after which a cell stops even with fewer runs than it needs
ENOUGH = 3  # runs; with these, a cell that agrees and shows its order is done
ORDER_SHOWN = 0.15  # an observed order this close to the documented one needs no finer run

Run = tuple[Settings, Record, Trajectory | None]
Progress = Callable[[int, int, str], None]  # (cells done, of how many, what comes next)


@dataclass(frozen=True)
class Cell:
    """One verdict. Numbers are of the run that speaks for the ladder; None with a reason where there is none."""

    scene: str
    parameters: dict[str, Any]
    engine: str
    method: str
    verdict: Verdict
    error: float | None  # m
    compliance: float | None  # m or rad
    order: float | None  # observed; of fixed-step methods
    reason: str
    uncertainty: float | None = None  # m, of the truth
    documented_order: int | None = None
    setting: str = ""  # of the run that speaks for the ladder
    loop_s: float | None = None
    contact: dict[str, float] = field(default_factory=dict)  # figures of the run that speaks for the ladder
    reaction_error: float | None = None  # N, N m, where reactions were compared
    runs: tuple[dict[str, Any], ...] = ()  # setting, status, error of each run

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self) | {"verdict": str(self.verdict)}


@dataclass(frozen=True)
class Climb:
    """The runs of one cell, coarse to fine."""

    settings: list[Settings]
    records: list[Record]
    rungs: list[Rung]


def check(
    scenes: Iterable[Scene], engines: Iterable[str] | None = None, progress: Progress | None = None, *,
    budget_s: float = BUDGET, call: Caller = direct,
) -> Iterator[Cell]:  # fmt: skip
    """Yield a verdict for every (scene, engine, method) as it is reached. ValueError where an engine is unknown.

    `call` makes the runs: cross_checks.isolation.parent survives engines that do not come back.
    """
    tasks = [
        (scene, engine, method)
        for scene in scenes
        for engine in (registry.names() if engines is None else list(engines))
        for method in _methods(engine)
    ]
    for done, (scene, engine, method) in enumerate(tasks):
        name = method.name if method else ""
        if progress is not None:
            progress(done, len(tasks), f"{scene.name} {engine} {name}".strip())
        yield missing(scene, engine) if method is None else judged(scene, engine, method, budget_s, call)
    if progress is not None:
        progress(len(tasks), len(tasks), "")


def _methods(engine: str) -> tuple[Method | None, ...]:
    try:
        return registry.get(engine).methods()
    except registry.EngineMissing:
        return (None,)


def missing(scene: Scene, engine: str) -> Cell:
    """Return the cell of an engine whose package is not installed."""
    record, _ = judged_run(scene, engine, Settings())
    assert record.status == MISSING
    return Cell(
        scene.name, dict(scene.parameters), engine, "", Verdict.ENGINE_MISSING, None, None, None, record.message
    )


def judged(scene: Scene, engine: str, method: Method, budget_s: float, call: Caller) -> Cell:
    """Return the method's cell; what is lost with its process is a verdict with a sentence."""
    try:
        return call(judge_method, scene, engine, method, budget_s)
    except Lost as lost:
        parameters = dict(scene.parameters)
        return Cell(scene.name, parameters, engine, method.name, Verdict(lost.status), None, None, None, str(lost))


def judge_method(
    scene: Scene, engine: str, method: Method, budget_s: float = BUDGET, *,
    rungs: Sequence[Settings] | None = None, reference: Trajectory | None = None,
) -> Cell:  # fmt: skip
    """Climb the method's ladder, or the `rungs` given, until it agrees or the budget is spent, and judge.

    `reference` gives joint reactions to compare with.
    """
    truth = seek_truth(scene, ladder.grid(scene))
    uncertainty = None if isinstance(truth, NoTruth) else truth.uncertainty
    climb = _climb(scene, method, runs(scene, engine, method, rungs, reference), budget_s)
    why = truth.reason if isinstance(truth, NoTruth) else ""
    agreement = AGREEMENT * unit_length(scene)
    verdict, reason = judge(climb.rungs, uncertainty or 0.0, why, agreement)
    best = telling(climb.rungs, agreement)
    record = None if best < 0 else climb.records[best]
    return Cell(
        scene=scene.name, parameters=dict(scene.parameters), engine=engine, method=method.name,
        verdict=verdict, reason=reason, uncertainty=uncertainty, documented_order=method.order,
        error=None if record is None or record.error is None else record.error.value,
        compliance=None if record is None else record.measure("compliance_position"),
        order=_order(method, climb, uncertainty or 0.0),
        setting="" if best < 0 else climb.rungs[best].setting,
        loop_s=None if record is None else record.times["loop_s"],
        contact={} if record is None else record.contact,
        reaction_error=None if record is None else record.measure("reaction_error"),
        runs=tuple({"setting": r.setting, "status": r.status, "error": r.error} for r in climb.rungs),
    )  # fmt: skip


def _climb(scene: Scene, method: Method, made: Iterable[Run], budget_s: float) -> Climb:
    climb = Climb([], [], [])
    start, before = time.perf_counter(), None
    for settings, record, path in made:
        climb.settings.append(settings)
        climb.records.append(record)
        climb.rungs.append(_rung(settings, record, path, before))
        before = path if record.status == "success" else before
        spent = time.perf_counter() - start
        if record.status in (Verdict.CANNOT, MISSING) or _is_done(scene, method, climb, spent, budget_s):
            break
    return climb


def runs(
    scene: Scene, engine: str, method: Method, rungs: Sequence[Settings] | None = None,
    reference: Trajectory | None = None,
) -> Iterator[Run]:  # fmt: skip
    """Run the method's ladder, or the `rungs` given, from coarse to fine, each rung as it is asked for."""
    times = ladder.grid(scene)
    for settings in ladder.rungs(method, scene) if rungs is None else rungs:
        record, path = judged_run(scene, engine, settings, times, reference=reference)
        yield settings, record, path


def _rung(settings: Settings, record: Record, path: Trajectory | None, before: Trajectory | None) -> Rung:
    error = record.error.value if record.error is not None else None
    both = path is not None and before is not None and record.status == "success"
    gap = float(max(distance(path.position, before.position))) if both else None  # type: ignore[union-attr]
    return Rung(ladder.label(settings), record.status, record.message, error, gap)


def _is_done(scene: Scene, method: Method, climb: Climb, spent_s: float, budget_s: float) -> bool:
    good = [r for r in climb.rungs if r.ok]
    agrees = len(good) >= ENOUGH and good[-1].error is not None and good[-1].error <= AGREEMENT * unit_length(scene)
    over = spent_s > budget_s and ((len(good) >= ENOUGH and is_telling(good)) or spent_s > PATIENCE * budget_s)
    return over or (agrees and (_shows_order(method, climb) or spent_s > 0.5 * budget_s))


def _shows_order(method: Method, climb: Climb) -> bool:
    order = _order(method, climb, 0.0)
    return order is None or method.order is None or abs(order - method.order) < ORDER_SHOWN


def _order(method: Method, climb: Climb, uncertainty: float) -> float | None:
    if method.kind != "fixed":
        return None
    pairs = zip(climb.settings, climb.rungs, strict=True)
    points = [(s.step, r.error) for s, r in pairs if r.ok and s.step and r.error]
    return observed_order([h for h, _ in points], [e for _, e in points], uncertainty) if points else None
