"""A cell of the validation matrix: what one method does on one scene, from the store's runs alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from cross_checks import engines as registry
from cross_checks.engine import Engine, Method
from cross_checks.engine.initial_state import broken_start
from cross_checks.judge.bounds import TARGETS
from cross_checks.judge.consensus import working_truth
from cross_checks.judge.runs import Runs
from cross_checks.judge.search import Tried, search
from cross_checks.judge.verdict import speaking
from cross_checks.judge.vocabulary import WRONG, TargetResult, Verdict
from cross_checks.metrics.observed_order import observed_order
from cross_checks.records.record import CANNOT, MISSING, Record
from cross_checks.truth import NoTruth, Truth
from mbs_ref.display import facts, listing
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings

Progress = Callable[[int, int, str], None]  # (cells done, of how many, what comes next)


@dataclass(frozen=True)
class Cell:
    """One verdict. Errors are over the scene's scales; None with a reason where there is none."""

    scene: str
    parameters: dict[str, Any]
    engine: str
    method: str
    verdict: Verdict
    reason: str
    excuse: str = ""  # why the method is known to go wrong on such a scene; empty where it is not
    error: float | None = None  # of the run that speaks for the method
    compliance: float | None = None  # m or rad
    order: float | None = None  # observed; of fixed-step methods
    documented_order: int | None = None
    uncertainty: float | None = None  # of the truth, over the scene's scales
    truth: str = ""  # its kind: exact, published, converged, or agreed by engines
    setting: str = ""  # of the run that speaks for the method
    loop_s: float | None = None
    contact: dict[str, float] = field(default_factory=dict)
    targets: tuple[TargetResult, ...] = ()
    runs: tuple[dict[str, Any], ...] = ()  # setting, status, error of each run, coarse to fine

    @property
    def is_wrong(self) -> bool:
        """Whether the verdict accuses, and nothing that the method declares excuses it here."""
        return self.verdict in WRONG and not self.excuse

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the verdict, why, and the runs it was made from."""
        told = facts(f"{self.scene}: {self.engine} {self.method}", [
            ("verdict", f"{self.verdict}: {self.reason}"), ("known", self.excuse), ("error of the scene", self.error),
            ("truth", self.truth), ("order", self.order), ("documented order", self.documented_order),
        ])  # fmt: skip
        runs = [(run["setting"], run["status"], run["error"]) for run in self.runs]
        return told + listing("Runs", ("setting", "status", "error of the scene"), runs)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, without the curves of the records."""
        plain = asdict(self) | {"verdict": str(self.verdict), "targets": [_told(t) for t in self.targets]}
        return plain


def truth_of(runs: Runs, scene: Scene) -> Truth | NoTruth:
    """Return the scene's certified truth, else what engines agree on, else why there is neither."""
    broken = broken_start(scene, Settings().initial_tolerance)
    if broken:
        return NoTruth(broken)
    truth = runs.truth(scene)
    return working_truth(runs, scene, truth.reason) if isinstance(truth, NoTruth) else truth


def tasks(engines: Iterable[str]) -> list[tuple[str, Method | None]]:
    """Return every method of the engines; None for an engine whose package is not installed. ValueError as `get`."""
    offered: list[tuple[str, Method | None]] = []
    for name in engines:
        try:
            offered += [(name, method) for method in registry.get(name).methods()]
        except registry.EngineMissing:
            offered.append((name, None))
    return offered


def check(
    runs: Runs, scenes: Iterable[Scene], engines: Sequence[str] | None = None, progress: Progress | None = None
) -> Iterator[Cell]:
    """Yield a cell for every scene, engine and method, as it is judged. ValueError where an engine is unknown."""
    offered = tasks(engines or registry.names())
    listed = [(scene, *task) for scene in scenes for task in offered]
    truths: dict[int, Truth | NoTruth] = {}
    for done, (scene, engine, method) in enumerate(listed):
        if progress is not None:
            progress(done, len(listed), f"{scene.name} {engine} {method.name if method else ''}".strip())
        if id(scene) not in truths:
            truths[id(scene)] = truth_of(runs, scene)
        yield judge_method(runs, scene, engine, method, truths[id(scene)])
    if progress is not None:
        progress(len(listed), len(listed), "")


def judge_method(
    runs: Runs, scene: Scene, engine: str, method: Method | None, truth: Truth | NoTruth,
    targets: Sequence[float] = TARGETS,
) -> Cell:  # fmt: skip
    """Search the method's settings and judge what they show."""
    name, refusal = refused(scene, engine, method)
    if refusal or method is None:
        verdict = Verdict(MISSING if method is None else CANNOT)
        return Cell(scene.name, dict(scene.parameters), engine, name, verdict, refusal)
    tried, answers = search(runs, scene, engine, method, truth, targets)
    return cell_of(tried, answers)


def refused(scene: Scene, engine: str, method: Method | None) -> tuple[str, str]:
    """Return the method's name and why it is not run; empty where it is."""
    if method is None:
        return "", f"engine {engine!r} is not installed"
    solver: Engine = registry.get(engine)
    reasons = [r.reason for r in (*solver.refusals(scene), *solver.method_refusals(scene, method))]
    broken = broken_start(scene, Settings().initial_tolerance)  # the scene's fault, not an engine's
    return method.name, "; ".join(dict.fromkeys([*reasons, broken] if broken else reasons))


def cell_of(tried: Tried, answers: Sequence[TargetResult]) -> Cell:
    """Return the verdict on runs that were made; the same runs give the same cell."""
    scene, truth, points, uncertainty = tried.scene, tried.truth, tried.points(), tried.uncertainty
    verdict, reason = tried.verdict()
    place = speaking(points)
    record: Record | None = None if place < 0 else tried.records[points[place].knob]
    return Cell(
        scene.name, dict(scene.parameters), tried.engine, tried.method.name, verdict, reason,
        excuse=tried.method.excused(scene),
        error=None if record is None or record.error is None else record.error.value,
        compliance=None if record is None else record.measure("compliance_position"),
        order=_order(tried, uncertainty or 0.0), documented_order=tried.method.order,
        uncertainty=uncertainty, truth="" if isinstance(truth, NoTruth) else truth.kind,
        setting="" if place < 0 else points[place].setting,
        loop_s=None if record is None else record.times.get("loop_s"),
        contact={} if record is None else record.contact, targets=tuple(answers),
        runs=tuple({"setting": p.setting, "status": p.status, "error": p.error} for p in points),
    )  # fmt: skip


def _order(tried: Tried, uncertainty: float) -> float | None:
    if tried.method.kind != "fixed" or not tried.good():
        return None
    steps, errors = zip(*tried.good(), strict=True)
    rounding = [tried.method.rounding(tried.records[step].steps) for step in steps]
    return observed_order(steps, errors, uncertainty, rounding)


def _told(reached: TargetResult) -> dict[str, Any]:
    record = reached.record
    plain = {"target": reached.target, "answer": reached.answer, "reason": reached.reason}
    if record is None or record.error is None:
        return plain
    return plain | {"settings": record.settings, "error": record.error.value, "loop_s": record.times.get("loop_s")}
