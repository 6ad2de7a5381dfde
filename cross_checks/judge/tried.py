"""One method on one scene as the search sees it: its runs, their errors and their gaps, from the store."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cross_checks import engines
from cross_checks.engine import Method
from cross_checks.isolation.workers import Over
from cross_checks.judge.bounds import AGREEMENT, FAILING, MOST_STEPS, TARGETS
from cross_checks.judge.ladder import SAMPLES, TIGHTEST, coarsest, knob_of, label, settings_at
from cross_checks.judge.runs import Runs, against, gap
from cross_checks.judge.search import Search
from cross_checks.judge.verdict import Judgement, Point, at_error
from cross_checks.judge.vocabulary import REFUSED, WRONG, Answer, TargetResult, Verdict
from cross_checks.metrics.metric import known_to
from cross_checks.records.record import Record
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import Scene, Trajectory
from mbs_ref.scene.scales import free_fall_time
from mbs_ref.scene.traits import is_smooth
from mbs_ref.simulate.linearised import may_be_stiff, stiffness_at_start

FIRST_RTOL, FIRST_STEP = 1e-5, 5e-3  # where the search begins; steps in free-fall times
STABLE = 0.7  # of the step that the linearised motion allows an explicit method
TYPICAL_RTOL, TYPICAL_STEPS = 1e-6, 1000  # a setting at which errors are typical before any run:
TYPICAL = 10.0  # times the tolerance; of steps, each order brings 1.2 decades
DECADES_PER_ORDER, MOST_ORDER = 1.2, 6


@dataclass(eq=False)
class Tried(Search):
    """The runs of one method on one scene."""

    runs: Runs
    scene: Scene
    engine: str
    method: Method
    truth: Truth | NoTruth
    most_steps: int = MOST_STEPS  # that a run may take
    records: dict[float, Record] = field(default_factory=dict)
    paths: dict[float, Trajectory | None] = field(default_factory=dict)
    gaps: dict[tuple[float, float], float] = field(default_factory=dict)
    missing: str = ""  # why the search ended before the run that was next

    def __post_init__(self) -> None:
        super().__init__()
        self.kind = self.method.kind
        self.duration, self.outputs, self.local_order = self.scene.duration, SAMPLES - 1, self.method.local_order
        self.documented_order = documented_order(self.method, self.scene)
        self.is_exempt = bool(self.method.exemption(self.scene))
        self.coarsest = coarsest(self.method, self.scene)
        self.finest = TIGHTEST if self.kind == "adaptive" else self.duration / self.most_steps
        self.why_no_truth = self.truth.reason if isinstance(self.truth, NoTruth) else ""
        self.uncertainty = 0.0 if isinstance(self.truth, NoTruth) else known_to(self.scene, self.truth)

    def verdict(self) -> Judgement:
        """Return the verdict on all runs; open where the run is missing that would show or confirm it."""
        judged = super().verdict()
        if not self.missing or judged.verdict not in {Verdict.NOT_SHOWN, *WRONG}:
            return judged
        return Judgement(Verdict.NOT_SHOWN, f"{judged.reason}; {self.missing}")

    def typed(self, knob: float) -> float:
        """Return a setting as a user types it: a step that divides the outputs, a tolerance of two digits."""
        return knob_of(settings_at(self.method, self.scene, min(max(knob, TIGHTEST), self.coarsest)))

    def run(self, knob: float) -> Point:
        """Return the run at a setting, judged."""
        settings = settings_at(self.method, self.scene, knob)
        seconds = self.seconds(float(self.steps(np.array([knob]))[0]))
        run = self.runs.run(self.scene, self.engine, settings, seconds or 0.0)
        record = against(self.scene, run, self.truth)
        self.records[knob], self.paths[knob] = record, run.path
        error = record.error.value if record.error is not None and record.status == "success" else None
        rounding = self.method.rounding(record.steps)
        return Point(label(settings), knob, record.status, record.message, error, record.steps, rounding)

    def gap(self, first: float, second: float) -> float:
        """Return the distance between two runs over the scene's scales; NaN where unknown."""
        key = (min(first, second), max(first, second))
        if key not in self.gaps:
            self.gaps[key] = gap(self.scene, self.truth, self.paths[first], self.paths[second])
        return self.gaps[key]

    def seconds(self, steps: float) -> float | None:
        """Return the processor time (s) of so many steps, by the longest run that succeeded, else of any; else None."""
        known = [self.records[point.knob] for point in self.good] or list(self.records.values())
        times = [(record.steps, record.times) for record in known if record.steps]
        made, spent = max(times, key=lambda one: one[0], default=(0, {}))
        cost = spent.get("loop_s", 0.0) * min(spent.get("cpu_share", 0.0), 1.0)
        return cost / made * steps if cost else None

    def affordable(self) -> float:
        """Return the most steps of a run for a target alone: a power of two, so that noise of times changes little."""
        a_step, longest = self.seconds(1.0), self.runs.longest
        return 2.0 ** math.ceil(math.log2(longest / a_step)) if a_step and longest < math.inf else math.inf

    def facts(self) -> dict:
        """Return what the ladder of this method states in addition to its runs."""
        return facts_of(self.method, self.scene, self.duration, self.uncertainty)

    def reference_error(self, knob: float) -> float | None:
        """Return the error of a method of that order or more at the same setting, of another package."""
        own, scene, library = self.method, self.scene, engines.get(self.engine).library
        for other in [one for one in engines.installed() if own.order is not None and one.library != library]:
            alike = [m for m in other.able(scene) if m.kind == own.kind and (m.order or 0) >= (own.order or 0)]
            sound = sorted([m for m in alike if not m.exemption(scene)], key=lambda m: m.order or 0)[:1]
            for method in sound:
                run = self.runs.run(scene, other.name, settings_at(method, scene, knob))
                record = against(scene, run, self.truth)
                if record.status == "success" and record.error is not None:
                    return record.error.value
        return None

    def representative(self, is_wrong: bool = False) -> Record | None:
        """Return the run that represents the method: the finest in agreement, else the finest that succeeded.

        Of a method that is classified as wrong, it is the run that has the error which the verdict states.
        """
        good, shown = self.good, self.shown()
        if is_wrong and shown is not None:
            return self.records[at_error(good, float(shown.ladder.errors[-1])).knob]
        agreeing = [point for point in good if point.error is not None and point.error <= AGREEMENT]
        return self.records[(agreeing or good)[-1].knob] if good else None


def documented_order(method: Method, scene: Scene) -> float:
    """Return the order that a verdict may expect: of a tolerance p / (p + 1), which controls the local error.

    It is 1 where forces jump between the steps of a method that locates no events.
    """
    p = float(method.order or (5 if method.kind == "adaptive" else 1))
    if method.kind == "adaptive":
        return p / (p + 1.0)
    return p if method.locates_events or is_smooth(scene) else min(p, 1.0)


def facts_of(method: Method, scene: Scene, duration: float, uncertainty: float) -> dict:
    """Return a ladder's facts for a method on a scene.

    It follows the order of a step, and of a tolerance that order over the power of the step that it controls.
    """
    order = method.order or 5
    expected = order / method.local_order if method.kind == "adaptive" else documented_order(method, scene)
    return typical_facts(method.kind, order, expected, duration, uncertainty)


def typical_facts(kind: str, order: int, expected: float, duration: float, uncertainty: float) -> dict:
    """Return a ladder's facts: the error that is typical at a setting before any run, of a documented order."""
    is_fixed = kind == "fixed"
    where = duration / TYPICAL_STEPS if is_fixed else TYPICAL_RTOL
    typical = -DECADES_PER_ORDER * min(order, MOST_ORDER) if is_fixed else math.log10(TYPICAL * TYPICAL_RTOL)
    return {"kind": kind, "order": expected, "reference": where, "typical": typical, "uncertainty": uncertainty}


def search(
    runs: Runs, scene: Scene, engine: str, method: Method, truth: Truth | NoTruth, targets: Sequence[float] = TARGETS,
    most_steps: int = MOST_STEPS, settle: bool = True,
) -> tuple[Tried, list[TargetResult]]:  # fmt: skip
    """Search the method's settings for every target; return all runs and what became of each target.

    Unless `settle`, no run serves the verdict. One open or wrong within `runs.longest` is sought without it; not
    where a documented weakness exempts the method, which neither verdict classifies. Where no time is left for a run,
    the search ends, and states so.
    """
    tried = Tried(runs, scene, engine, method, truth, most_steps)
    try:
        runs_at_all = tried.begin(first_knob(scene, method))
        if runs_at_all and isinstance(truth, Truth):
            tried.reach(sorted(targets, reverse=True))
        is_open = runs_at_all and settle and tried.settle().verdict in {Verdict.NOT_SHOWN, *WRONG}
    except Over as over:
        tried.missing, is_open = f"beyond the time left: {over}", False
    if not tried.good:
        refused = all(record.status in REFUSED for record in tried.records.values())
        answer: Answer = "not-tried" if tried.missing else "cannot" if refused else "not-reached"
        why = tried.missing or tried.records[tried.knobs[-1]].message or tried.records[tried.knobs[-1]].status
        return tried, [TargetResult(target, answer, None, why) for target in targets]
    if is_open and not tried.is_exempt and runs.longest < math.inf:
        return search(replace(runs, longest=math.inf), scene, engine, method, truth, targets, most_steps)
    return tried, [_result(tried, target, settle) for target in sorted(targets, reverse=True)]


def first_knob(scene: Scene, method: Method) -> float:
    """Return where the search begins: within what a stiff motion allows, where the method is explicit."""
    if method.kind == "adaptive":
        return FIRST_RTOL
    step = min(FIRST_STEP * free_fall_time(scene), coarsest(method, scene))
    if method.stability and may_be_stiff(scene):
        step = min(step, STABLE * stiffness_at_start(scene).step_limit(method.stability))
    return step


def _result(tried: Tried, target: float, settled: bool) -> TargetResult:
    """Return what became of a target, from all runs within the work limit and a verdict that is settled or not."""
    # a step is shortened to divide the outputs, so that the finest one may be beyond the work limit by a percent
    good, most, least = tried.good, 1.01 * tried.most_steps, 0.99 * tried.finest if tried.kind == "fixed" else math.inf
    records = [tried.records[point.knob] for point in good if point.knob >= least or point.steps <= most]
    if isinstance(tried.truth, NoTruth):
        return TargetResult(target, "unjudged", None, tried.truth.reason)
    record = next((r for r in records if r.error is not None and r.error.bound <= target), None)
    if record is not None:
        return TargetResult(target, "reached", record)
    best = min((r.error.value for r in records if r.error is not None), default=math.inf)
    if min(target, best - target) <= tried.uncertainty:
        why = f"the best error is {best:.1e}, and the truth is known to {tried.uncertainty:.1e}"
        return TargetResult(target, "unjudged", None, why)
    omitted, verdict = tried.omitted(target - tried.uncertainty), tried.verdict()
    if tried.missing:
        return TargetResult(target, "not-tried", None, tried.missing, omitted)
    if omitted is not None and (finest := tried.knobs[-1]) == good[-1].knob:
        is_possible = verdict.verdict not in WRONG and omitted.reaches > 1.0 - FAILING
        if is_possible or (not settled and omitted.setting < finest):
            return TargetResult(target, "not-tried", None, f"it would take {omitted}", omitted)
    return TargetResult(target, "not-reached", None, f"the best error is {best:.1e}; {verdict.reason}", omitted)
