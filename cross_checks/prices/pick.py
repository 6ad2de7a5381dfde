"""The cheapest measured setting that reaches an accuracy, why no cheaper one does, and runs that confirm it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cross_checks import engines
from cross_checks.isolation.parent import Caller, Lost, direct
from cross_checks.judge import ladder
from cross_checks.judge.cell import truth_of
from cross_checks.judge.one_run import evaluate, without_run
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import OURS
from cross_checks.prices.timing import Comparison, Pace, compare, sample
from cross_checks.records.record import MISSING, Record, best_of_engines, floor, known_error, loop_time, usable
from cross_checks.truths.truth import NO_ERROR, NoTruth, Truth
from mbs_ref import Scene, Settings, Status
from mbs_ref.display import facts

RIVAL = 5.0  # of the cheapest loop time: one that is measured beside other runs is off by less than this factor
CLOSE = 1.5  # a margin below this may be noise: the two are timed against each other
OUTPUTS = 11  # output times of an engine with its default settings
WORDS = {
    Pace.SLOWER: "Confirmed by",
    Pace.FASTER: "Overturned by",
    Pace.SAME: "A tie in",
    Pace.INCONCLUSIVE: "Not settled by",
}


@dataclass(frozen=True)
class Limit:
    """The bound that rules the cheaper settings out, and the one of them that comes nearest to it."""

    bound: str  # error | compliance
    cheaper: Record


@dataclass(frozen=True)
class Choice:
    """The recommendation, or the sentence why there is none."""

    best: Record | None
    runner_up: Record | None  # the cheapest of another engine; of another method where one engine alone reaches it
    margin: float | None  # how many times cheaper the best is than the runner-up
    sentence: str
    limit: Limit | None = None  # None where nothing measured is cheaper, or only for failing both bounds

    def _repr_html_(self) -> str:
        return facts("Choice", [("answer", self.sentence)]) + ("" if self.best is None else self.best._repr_html_())


@dataclass(frozen=True)
class Bounds:
    """The requirements on a run: error (over the scene's scales), compliance (m, rad) and loop time (s)."""

    error: float
    compliance: float | None = None
    budget: float | None = None

    def __post_init__(self) -> None:
        for name in ("error", "compliance", "budget"):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise ValueError(f"{name} = {value} must be positive")

    def error_ok(self, record: Record) -> bool:
        return record.error is not None and record.error.bound <= self.error

    def compliance_ok(self, record: Record) -> bool:
        position = record.measure("compliance_position")
        return self.compliance is None or (position is not None and position <= self.compliance)

    def met_by(self, record: Record) -> bool:
        """Whether the run finished with error and compliance within bounds, whatever its time."""
        return record.status == "success" and self.error_ok(record) and self.compliance_ok(record)


def pick(
    records: Iterable[Record], error: float, compliance: float | None = None, budget: float | None = None
) -> Choice:
    """Return the cheapest measured setting with error (of the scene's scales), compliance (m, rad), loop (s) in bounds.

    Only measured runs count, nothing is extrapolated, and the truth's uncertainty is added to the
    error. No setting is chosen for an error below the truth's uncertainty.
    ValueError where a bound is not positive or the records are of several scenes.
    """
    bounds = Bounds(error, compliance, budget)
    listed = list(records)
    measured = [r for r in listed if usable(r)]
    if not measured:
        return Choice(None, None, None, _why_nothing(listed))
    scenes = {(r.scene, tuple(sorted(r.parameters.items()))) for r in measured}
    if len(scenes) > 1:
        raise ValueError(f"the records belong to {len(scenes)} scenes; give the records of one scene")
    if error < (resolved := floor(measured)):
        return Choice(None, None, None, f"the truth of this scene resolves no error below {resolved:.1e} of it")
    reached = [r for r in measured if bounds.met_by(r)]
    affordable = sorted((r for r in reached if budget is None or loop_time(r) <= budget), key=loop_time)
    if not affordable:
        return Choice(None, None, None, _why_none(measured, reached, bounds))
    best = affordable[0]
    others = [r for r in affordable if r.engine != best.engine] or [r for r in affordable if r.method != best.method]
    second = next(iter(others), None)
    margin = None if second is None else loop_time(second) / loop_time(best)
    limit = _limit([r for r in measured if loop_time(r) < loop_time(best)], bounds)
    sentences = [_why(best, second, margin)] + ([] if limit is None else [_why_not_cheaper(limit)])
    return Choice(best, second, margin, " ".join(sentences), limit)


def contenders(records: Iterable[Record], bounds: Bounds) -> list[Record]:
    """Return the runs that may prove the cheapest within the bounds once they are timed alone."""
    reached = [record for record in records if usable(record) and bounds.met_by(record)]
    return [record for record in reached if loop_time(record) <= RIVAL * min(map(loop_time, reached))]


def basis(records: Iterable[Record]) -> str:
    """Return a sentence on what the errors of the records are from."""
    errors = [record.error for record in records if record.error is not None]
    if not errors:
        return "No truth is known yet."
    best = min(errors, key=lambda error: error.uncertainty)
    return f"Errors are from a truth known to {best.uncertainty:.1e} of the scene: {best.truth}."


def of_engines(records: Sequence[Record], bounds: Bounds) -> list[str]:
    """Return a sentence on each installed engine: its cheapest setting within the error, its nearest, or why none."""
    installed = [record for record in records if record.status != MISSING]
    failures, sentences = _failures(installed), []
    for best in best_of_engines(installed, bounds.error):
        if not usable(best):
            sentences.append(f"{best.engine} does not run it: {failures.get(best.engine, 'no error is known')}")
            continue
        price = f"{_length(best)} in {loop_time(best) * 1e3:.3g} ms"
        missed = "" if bounds.met_by(best) else "none within the bounds; the nearest is "
        sentences.append(f"{best.engine}: {missed}{setting(best).removeprefix(best.engine).strip()}, {price}")
    return sentences


def shipped(record: Record) -> str:
    """Return one sentence of what an engine does as it comes."""
    how = f"{record.engine} as it comes ({setting(record).removeprefix(record.engine).strip()})"
    if record.status != "success":
        return f"{how} ends with {record.status}: {record.message}"
    return f"{how}: {_length(record)} in {loop_time(record) * 1e3:.3g} ms"


def _length(record: Record) -> str:
    """Return an error in words, as a share of the scene and as a length."""
    if record.error is None:
        return "no known error"
    return f"{record.error.bound:.1e} of the scene ({record.error.bound * record.error.length:.1e} m)"


def _gap(record: Record) -> float:
    position = record.measure("compliance_position")
    return float("inf") if position is None else position


def _limit(cheaper: Sequence[Record], bounds: Bounds) -> Limit | None:
    """Name the bound that a cheaper setting misses alone, the joints' first: loosening it keeps the error."""
    rules = ("compliance", bounds.error_ok, _gap), ("error", bounds.compliance_ok, known_error)
    for bound, other_ok, distance in rules:
        near = min((r for r in cheaper if other_ok(r)), key=distance, default=None)
        if near is not None:
            return Limit(bound, near)
    return None


def setting(record: Record) -> str:
    """Return engine, method and step or tolerance as a reader would say them."""
    step, rtol = record.settings.get("step"), record.settings.get("rtol")
    how = f"step={step:.6g}" if step is not None else f"rtol={rtol:.1g}" if rtol is not None else "its defaults"
    return f"{record.engine} {record.method} {how}"


def _why(best: Record, second: Record | None, margin: float | None) -> str:
    whose = ", this project's own solver," if best.engine == OURS else ""
    text = f"{setting(best)}{whose} reaches {_length(best)} in {1e3 * loop_time(best):.3g} ms"
    if second is None or margin is None:
        return f"{text}; no other engine or method reaches it."
    return f"{text}, {margin:.3g} times cheaper than {setting(second)} ({1e3 * loop_time(second):.3g} ms)."


def _why_not_cheaper(limit: Limit) -> str:
    near, price = limit.cheaper, f"{1e3 * loop_time(limit.cheaper):.3g} ms"
    if limit.bound == "error":
        return f"The error limits it: for {price} the nearest is {setting(near)} with {_length(near)}."
    gap = near.measure("compliance_position")
    known = "is not known to keep the joints closed" if gap is None else f"opens the joints by {gap:.1e}"
    return f"The compliance limits it: for {price} {setting(near)} {known}."


def _why_nothing(records: Sequence[Record]) -> str:
    """Return why no run was measured: that no truth is known of those that succeeded, else why none did."""
    notes = [note for r in records if r.status == Status.SUCCESS for note in r.notes if note.startswith(NO_ERROR)]
    why = notes[-1:] or [f"{name}: {why}" for name, why in _failures(records).items()]
    return "; ".join(["no run with a known error was measured", *why])


def _failures(records: Iterable[Record]) -> dict[str, str]:
    """Return the shortest message of each engine's methods that do not run the scene."""
    words: dict[str, str] = {}
    for record in records:
        if record.status != Status.SUCCESS and record.message:
            words[record.engine] = min(words.get(record.engine, record.message), record.message, key=len)
    return words


def _why_none(measured: Sequence[Record], reached: Sequence[Record], bounds: Bounds) -> str:
    if reached and bounds.budget is not None:
        cheapest = min(reached, key=loop_time)
        price = f"{1e3 * loop_time(cheapest):.3g} ms"
        return f"none within {1e3 * bounds.budget:.3g} ms; the cheapest is {setting(cheapest)} at {price}"
    close = [r for r in measured if bounds.error_ok(r)]
    if close and bounds.compliance is not None:
        count, tight = len(close), bounds.compliance
        return f"{count} settings reach {bounds.error:.1e}, but none keeps the constraints within {tight:.1e}"
    nearest = min(measured, key=known_error)
    return f"none reached {bounds.error:.1e} of the scene; the nearest is {setting(nearest)} with {_length(nearest)}"


def duel(scene: Scene, choice: Choice, call: Caller = direct) -> Comparison:
    """Time the runner-up against the best in interleaved pairs; the ratio is the runner-up's time over the best's.

    ValueError where there is no runner-up.
    """
    if choice.best is None or choice.runner_up is None:
        raise ValueError("there is no runner-up to time the best against")
    first, second = ((r.engine, Settings(**r.settings)) for r in (choice.best, choice.runner_up))
    return compare(lambda: call(sample, scene, *first), lambda: call(sample, scene, *second))


def settled(choice: Choice, comparison: Comparison) -> Choice:
    """Return the choice as the duel leaves it: the two change places where the runner-up is the faster."""
    assert choice.best is not None
    assert choice.runner_up is not None
    first, second, ratio = choice.best, choice.runner_up, comparison.ratio
    if comparison.pace is Pace.FASTER:
        first, second, ratio = second, first, 1.0 / ratio
    interval = f"{comparison.ratio:.3g} [{comparison.low:.3g}, {comparison.high:.3g}]"
    blocks = f"{WORDS[comparison.pace]} {comparison.blocks} interleaved blocks"
    text = f"{blocks}: {setting(choice.runner_up)} takes {interval} times as long as {setting(choice.best)}."
    sentence = f"{choice.sentence} {text}"
    return replace(choice, best=first, runner_up=second, margin=ratio, sentence=sentence)


def as_shipped(runs: Runs, scene: Scene, engine: str) -> Record | None:
    """Return the run of an engine as it comes, compared with the scene's truth at its own steps.

    None where the engine is not installed or does not say how it comes.
    """
    try:
        given = engines.get(engine).as_shipped
    except engines.EngineMissing:
        return None
    if given is None or given.step is None:
        return None
    whole = max(1, int(scene.duration / given.step))
    own = replace(runs, times=np.unique(np.linspace(0.0, whole, min(OUTPUTS, whole + 1)).round()) * given.step)
    return own.judged(scene, engine, given, truth_of(own, scene))


def afresh(scene: Scene, record: Record, truth: Truth | NoTruth, call: Caller = direct) -> Record:
    """Run a record's setting again, whatever the store holds, and hold it against the truth."""
    settings = Settings(**record.settings)
    try:
        return call(_judged, scene, record.engine, settings, truth)
    except Lost as lost:
        return without_run(scene, record.engine, settings, lost.status, str(lost))


def _judged(scene: Scene, engine: str, settings: Settings, truth: Truth | NoTruth) -> Record:
    return evaluate(scene, engine, settings, ladder.grid(scene), truth=truth)
