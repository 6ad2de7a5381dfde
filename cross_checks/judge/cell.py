"""A cell of the validation matrix: what one method does on one scene, from the store's runs alone."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from cross_checks import engines as registry
from cross_checks.engine import Method
from cross_checks.engine.plan import broken_start
from cross_checks.judge.bounds import MOST_STEPS, TARGETS
from cross_checks.judge.consensus import ENOUGH, working_truth
from cross_checks.judge.ladder import label
from cross_checks.judge.runs import Runs
from cross_checks.judge.tried import Tried, search
from cross_checks.judge.verdict import Judgement
from cross_checks.judge.vocabulary import SILENT, Cell, TargetResult, Verdict
from cross_checks.records.record import Record
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Settings

ALONE = "one package, not certified"
BY_TRUTH = SILENT | {Verdict.AGREES, Verdict.BELOW_TRUTH, Verdict.CONVERGING}  # verdicts that a truth decides


def truth_of(runs: Runs, scene: Scene, enough: float = ENOUGH) -> Truth | NoTruth:
    """Return the scene's certified truth, else what engines agree on, else why there is neither.

    Engines run until they know the scene to `enough` of its scales.
    """
    if broken := broken_start(scene, Settings().initial_tolerance):
        return NoTruth(broken)
    truth = runs.truth(scene)
    return working_truth(runs, scene, truth.reason, enough) if isinstance(truth, NoTruth) else truth


def tasks(engines: Iterable[str]) -> list[tuple[str, Method | None]]:
    """Return every method of the engines; None for an engine whose package is not installed. ValueError as `get`."""
    offered: list[tuple[str, Method | None]] = []
    for name in engines:
        try:
            offered += [(name, method) for method in registry.get(name).methods()]
        except registry.EngineMissing:
            offered.append((name, None))
    return offered


def judged(
    runs: Runs, scene: Scene, engine: str, method: Method | None, truth: Truth | NoTruth,
    targets: Sequence[float] = TARGETS, most_steps: int = MOST_STEPS, settle: bool = True,
) -> tuple[Cell, tuple[Record, ...]]:  # fmt: skip
    """Return the method's cell and the records that it is based on, coarse to fine; none of a method that is refused.

    No run takes more than `most_steps`; unless `settle`, none is run for the verdict.
    """
    refusal = refusal_of(scene, engine, method, targets)
    if refusal is not None or method is None:
        return refusal, ()  # type: ignore[return-value] - None only with a method
    tried, results = search(runs, scene, engine, method, truth, targets, most_steps, settle)
    return cell_of(tried, results), tuple(tried.records[knob] for knob in tried.knobs)


def refusal_of(scene: Scene, engine: str, method: Method | None, targets: Sequence[float] = TARGETS) -> Cell | None:
    """Return the cell of a method that cannot run the scene, with every reason; None where it can."""
    name, verdict, reason = "", Verdict.ENGINE_MISSING, f"engine {engine!r} is not installed"
    if method is not None:
        broken = broken_start(scene, Settings().initial_tolerance)  # the scene's fault, not an engine's
        reason = "; ".join(filter(None, (registry.get(engine).refusal(scene, method), broken)))
        name, verdict = method.name, Verdict.CANNOT
    missed = tuple(TargetResult(target, "cannot", None, reason) for target in targets)
    cell = Cell(scene.name, dict(scene.parameters), engine, name, verdict, reason, targets=missed)
    return cell if reason else None


def cell_of(tried: Tried, results: Sequence[TargetResult]) -> Cell:
    """Return the verdict on a search; the same runs give the same cell."""
    scene, truth = tried.scene, tried.truth
    judgement, results = _of_one_package(truth, tried.verdict(), results)
    record = tried.representative(judgement.verdict in SILENT)
    if truth.kind == "proven" and judgement.verdict in SILENT:
        judgement = judgement._replace(reason=f"{judgement.reason}; wrong by a theorem: the motion is proven")
    points, shown = (tried.points[knob] for knob in tried.knobs), tried.shown()
    return Cell(
        scene.name, dict(scene.parameters), tried.engine, tried.method.name, judgement.verdict, judgement.reason,
        odds=judgement.odds,
        exemption=tried.method.exemption(scene),
        error=None if record is None or record.error is None else record.error.value,
        compliance=None if record is None else record.measure("compliance_position"),
        order=None if shown is None or tried.kind == "adaptive" else shown.observed_order,
        documented_order=tried.method.order,
        uncertainty=None if isinstance(truth, NoTruth) else tried.uncertainty,
        truth="" if isinstance(truth, NoTruth) else truth.kind,
        setting="" if record is None else label(Settings(**record.settings)),
        loop_s=None if record is None else record.times.get("loop_s"),
        contact={} if record is None else record.contact,
        targets=tuple(replace(r, record=r.record and replace(r.record, history={})) for r in results),
        runs=tuple({"setting": p.setting, "status": p.status, "error": p.error} for p in points),
    )  # fmt: skip


def _of_one_package(
    truth: Truth | NoTruth, judged: Judgement, results: Sequence[TargetResult]
) -> tuple[Judgement, Sequence[TargetResult]]:
    """Return what is shown where one package alone knows the motion: it confirms no method and calls none wrong."""
    if truth.kind != "one-package":
        return judged, results
    unjudged = [replace(one, answer="unjudged", reason=ALONE) if one.record else one for one in results]
    is_open = judged.verdict in BY_TRUTH
    return (Judgement(Verdict.NOT_SHOWN, f"{ALONE}: {judged.reason}") if is_open else judged), unjudged
