"""Find, for every target error, the cheapest setting of a method that reaches it, in as few runs as its order tells.

The error follows a power of the setting, e = C s^p. One run gives C; the documented order tells where each target is
met; runs made so far, two by two, tell the order better. A setting that is refused or fails is a bound on the coarse
side, and the search goes on beyond it. Work is counted in steps, the same for every engine, so that what is tried
does not depend on how busy a machine is; a target that would cost more is `not tried`, with the steps it would take.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from cross_checks.engine import Method
from cross_checks.judge.bounds import MOST_STEPS, TARGETS
from cross_checks.judge.control import control
from cross_checks.judge.ladder import SAMPLES, TIGHTEST, coarsest, knob_of, label, settings_at
from cross_checks.judge.runs import Runs, against, gap
from cross_checks.judge.verdict import BOUNCE, PLAIN, RESOLVED, STALLED, STAYING, Control, Point, judge
from cross_checks.judge.vocabulary import AGREEMENT, REFUSED, Answer, TargetResult, Verdict
from cross_checks.records.record import Record
from cross_checks.truth import NoTruth, Truth
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import is_smooth
from mbs_ref.scene.units import free_fall_time
from mbs_ref.self_checks.stiffness import may_be_stiff, stiffness_at_start
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory

WINDOW = 10.0  # a chosen error lies within this factor below its target
AIM = 0.3  # of the target: the middle of the window, on a logarithmic scale
TRIES = 4  # runs for one target, beside those of the others
SPREAD = 0.2  # of the documented order: how far the order that a scene shows lies from it
BACK = 4.0  # factor to a finer step after one that was refused or failed; its square for a tolerance
LEAP = 2.0  # power by which such a factor grows from one to the next
FIRST_RTOL, FIRST_STEP = 1e-5, 5e-3  # where the search begins; steps in s, or in free-fall times
STABLE = 0.7  # of the step that the linearised motion bears
NEXT_TO_NONE = 0.1  # of the steps or of a setting: less is no difference
TINY = 1e-300  # an error of zero has no logarithm
TOO_SMALL = "step-too-small"  # what a method says that finds no step short enough: a tighter tolerance asks for more
ENOUGH = 3  # runs that show whether a method converges

@dataclass
class Tried:
    """The runs of one method on one scene, coarse to fine."""

    scene: Scene
    engine: str
    method: Method
    truth: Truth | NoTruth
    most_steps: int = MOST_STEPS  # that a run may take
    records: dict[float, Record] = field(default_factory=dict)
    paths: dict[float, Trajectory | None] = field(default_factory=dict)
    control: Control | None = None  # of runs that are as far from one another as from the truth
    appeal: Point | None = None  # a run plainly finer than the others, of a method that would be accused

    @property
    def knobs(self) -> list[float]:
        """The settings tried, coarse to fine."""
        return sorted(self.records, reverse=True)

    @property
    def order(self) -> float:
        """The order of the error in the setting: documented for steps; proportionality for tolerances."""
        return 1.0 if self.method.kind == "adaptive" else float(self.method.order or 1)

    @property
    def foretold(self) -> float:
        """The order that the search expects: p of a step; of a tolerance that over the power its estimate follows.

        So errors are proportional to the tolerance of a pair that goes on from its better solution, p(p - 1).
        """
        return (self.method.order or 5) / self.method.local_order if self.method.kind == "adaptive" else self.order

    @property
    def promised(self) -> float:
        """The order that a verdict may ask: no more than first where forces jump or bend between a method's steps.

        Of a tolerance p / (p + 1), which an estimate of the local error itself leaves.
        """
        if self.method.kind == "adaptive":
            p = self.method.order or 5
            return p / (p + 1)
        is_first = not self.method.locates_events and not is_smooth(self.scene)
        return min(self.order, 1.0) if is_first else self.order

    def good(self) -> list[tuple[float, float]]:
        """Return setting and error of every run that succeeded, coarse to fine."""
        runs = ((knob, self.records[knob]) for knob in self.knobs)
        return [(knob, r.error.value) for knob, r in runs if r.status == "success" and r.error is not None]

    def sound(self) -> list[tuple[float, float]]:
        """Return what the law of errors is read from: runs within WINDOW of what two coarser ones reached.

        The others have lost their way, as by a wrong turn in a singular pose, and bound a search as failed ones do.
        """
        good = self.good()
        reached = [sorted(error for _, error in good[:place]) for place in range(len(good))]
        return [
            run for run, better in zip(good, reached, strict=True) if not better[1:] or run[1] <= WINDOW * better[1]
        ]

    def points(self) -> list[Point]:
        """Return what the verdict asks, coarse to fine, gaps between levels among them."""
        points, level, coarser = [], None, None
        for knob in self.knobs:
            record, path = self.records[knob], self.paths[knob]
            ok, refines = record.status == "success", self.refines(knob)
            if ok and refines:
                level, coarser = path, level
            points.append(self.point(record, gap(self.scene, path, coarser) if ok else None, refines))
            level = path if ok else level
        return points

    def point(self, record: Record, apart: float | None = None, refines: bool = True) -> Point:
        """Return what the verdict asks of one run."""
        error = record.error.value if record.error is not None and record.status == "success" else None
        settings = Settings(**record.settings)
        rounding = self.method.rounding(record.steps)
        return Point(label(settings), knob_of(settings), record.status, record.message, error, apart, refines, rounding)

    @property
    def uncertainty(self) -> float | None:
        """How well the truth is known over the scene's scales; None where no run has an error."""
        return next((r.error.uncertainty for r in self.records.values() if r.error is not None), None)

    def verdict(self) -> tuple[Verdict, str]:
        """Return what the runs show, and its sentence."""
        why = self.truth.reason if isinstance(self.truth, NoTruth) else ""
        return judge(self.points(), self.promised, self.uncertainty or 0.0, why, self.control, self.appeal)

    def refines(self, knob: float) -> bool:
        """Whether a setting takes more steps than every coarser one, or does not say how many it takes."""
        steps = [r.steps for k, r in self.records.items() if k > knob and r.status == "success"]
        return not steps or self.records[knob].steps == 0 or self.records[knob].steps > max(steps)

    def is_scattered(self) -> bool:
        """Whether the finest two runs are no approach to anything: far from the truth, and from one another."""
        good = self.good()[-2:]
        if len(good) < 2 or good[-1][1] <= RESOLVED:
            return False
        apart = gap(self.scene, *(self.paths[knob] for knob, _ in good))
        return apart is not None and apart > RESOLVED

    def levels(self) -> int:
        """Return how many refinements there are among the runs that succeeded."""
        return sum(self.records[knob].status == "success" and self.refines(knob) for knob in self.knobs)


def search(
    runs: Runs, scene: Scene, engine: str, method: Method, truth: Truth | NoTruth, targets: Sequence[float] = TARGETS,
    most_steps: int = MOST_STEPS,
) -> tuple[Tried, list[TargetResult]]:  # fmt: skip
    """Search the method's settings for every target; return all runs made and what became of each target.

    No setting is tried that would take more than `most_steps`, but for the appeal of a method that would be accused.
    """
    tried = Tried(scene, engine, method, truth, most_steps)
    if not _begin(runs, tried):
        refused = all(record.status in REFUSED for record in tried.records.values())
        answer: Answer = "cannot" if refused else "not-reached"
        return tried, [TargetResult(target, answer, None, _last_words(tried)) for target in targets]
    if isinstance(truth, NoTruth):
        _support(runs, tried)
        return tried, [TargetResult(target, "unjudged", None, truth.reason) for target in targets]
    answers = [_aim(runs, tried, target) for target in sorted(targets, reverse=True)]
    if not _is_shown(tried):
        _support(runs, tried)
    if tried.is_scattered():
        tried.control = control(runs, scene, engine, method, tried.good()[-1][0], truth)
    tried.appeal = _appeal(runs, tried)
    return tried, [_answer(tried, answer) for answer in answers]


def _appeal(runs: Runs, tried: Tried) -> Point | None:
    """Return a run plainly finer than all others, of a method that would be accused of staying off the truth.

    The bound on work is ours: a method that needs more is slow, not wrong.
    """
    finest = tried.knobs[-1]
    if tried.verdict()[0] not in STAYING or tried.method.excused(tried.scene):
        return None
    if tried.records[finest].status != "success" or _same_as_tried(tried, finest / _factor(tried)):
        return None
    settings = settings_at(tried.method, tried.scene, finest / _factor(tried))
    return tried.point(against(tried.scene, runs.run(tried.scene, tried.engine, settings), tried.truth))


def _begin(runs: Runs, tried: Tried) -> bool:
    """Find a first setting at which the method runs: finer ones where it is refused or fails.

    Steps in growing leaps; of tolerances the middle and the tightest.
    """
    finest = TIGHTEST if tried.method.kind == "adaptive" else tried.scene.duration / tried.most_steps
    for knob in _first_knobs(tried, max(first_knob(tried.scene, tried.method), finest), finest):
        record = _try(runs, tried, knob)
        if record.status == "success":
            return True
        if record.status == TOO_SMALL or (record.status in REFUSED and not _names_a_setting(record)):
            return False
    return False


def _first_knobs(tried: Tried, first: float, finest: float) -> Iterator[float]:
    yield first
    if tried.method.kind == "adaptive":
        yield from (math.sqrt(first * finest), finest)
        return
    knob, factor = first, BACK
    while knob > BACK * finest:
        knob, factor = max(knob / factor, finest), factor**LEAP
        yield knob


def _factor(tried: Tried) -> float:
    """Return the factor between a setting and a plainly finer one."""
    return BACK if tried.method.kind == "fixed" else BACK**2


def _names_a_setting(record: Record) -> bool:
    """Whether another step may be admitted: what is refused for its scene is refused at every step."""
    return "step" in record.message


def first_knob(scene: Scene, method: Method) -> float:
    """Return where the search begins: within what a stiff motion bears, where the method is explicit."""
    if method.kind == "adaptive":
        return FIRST_RTOL
    step = min(FIRST_STEP * free_fall_time(scene), coarsest(method, scene))
    if method.stability and may_be_stiff(scene):
        step = min(step, STABLE * stiffness_at_start(scene).step_limit(method.stability))
    return step


def _aim(runs: Runs, tried: Tried, target: float) -> TargetResult:
    """Try settings until one meets the target from within its window, or it is plain that none will."""
    for left in range(TRIES, -1, -1):
        if _is_met(tried, target) or _is_over(tried):
            break
        knob = _next(tried, target)
        if _steps(tried, knob) > tried.most_steps:
            return TargetResult(target, "not-tried", None, f"it would take about {_steps(tried, knob):.1g} steps")
        if not left or _same_as_tried(tried, knob) or _is_vain(tried, knob, target):
            break
        _try(runs, tried, knob)
    return TargetResult(target, "not-reached")


def _next(tried: Tried, target: float) -> float:
    """Return the setting to try next: for the middle of the window, or its edge where the middle costs too much.

    Too few runs foretell no cost: then a finer setting is tried to see the order.
    """
    middle, edge = _aimed(tried, AIM * target), _aimed(tried, target)
    if _steps(tried, middle) <= tried.most_steps:
        return middle
    finer = tried.good()[-1][0] / _factor(tried)
    able = (edge, finer) if len(tried.good()) < ENOUGH else (edge,)
    return next((k for k in able if _steps(tried, k) <= tried.most_steps and not _same_as_tried(tried, k)), middle)


def _is_met(tried: Tried, target: float) -> bool:
    """Whether the coarsest run that reaches the target does so from within the window, or none is cheaper."""
    reaching = [(knob, error) for knob, error in tried.good() if error <= target]
    if not reaching:
        return False
    knob, error = reaching[0]
    coarser = [other for other in tried.knobs if other > knob]
    is_near = bool(coarser) and _is_close(tried, min(coarser), knob)
    is_cheapest = any(tried.records[finer].steps <= tried.records[knob].steps for finer, _ in reaching[1:2])
    return error >= target / WINDOW or is_near or is_cheapest or _is_idle(tried, knob)


def _is_close(tried: Tried, coarser: float, knob: float) -> bool:
    """Whether no setting between two is worth a run: the window is narrower than what lies between them."""
    return (coarser / knob) ** tried.order <= WINDOW**0.5


def _aimed(tried: Tried, error: float) -> float:
    """Return the setting at which a power law through two runs meets `error`: around it where there are such.

    A setting beyond one that failed gives way to the middle between that one and the nearest that did not. A step
    leaps once over one that failed, for the iteration of an implicit method may converge at a finer one.
    """
    good = tried.sound()
    around = _around(good, error)
    wanted = _typed(tried, _between(tried, *around, error) if around else _beyond(tried, error))
    failed = set(tried.knobs) - {knob for knob, _ in good}
    coarser, finer = [k for k in failed if k > good[0][0]], [k for k in failed if k < good[-1][0]]
    if coarser and wanted >= min(coarser):
        wanted = math.sqrt(min(coarser) * good[0][0])
    if finer and wanted <= max(finer):
        beyond = max(min(wanted, min(finer) / BACK), tried.scene.duration / tried.most_steps)
        leaps = tried.method.kind == "fixed" and len(finer) == 1 and beyond < min(finer)
        wanted = _typed(tried, beyond) if leaps else math.sqrt(max(finer) * good[-1][0])
    return wanted


def _typed(tried: Tried, knob: float) -> float:
    """Return the setting that stands for a wish: within bounds, a step that divides the outputs, a short tolerance."""
    bounded = min(max(knob, TIGHTEST), coarsest(tried.method, tried.scene))
    return knob_of(settings_at(tried.method, tried.scene, bounded))


def _around(good: list[tuple[float, float]], error: float) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return the coarsest run that reaches `error` and its coarser neighbour, which does not; None without both."""
    place = next((k for k, (_, reached) in enumerate(good) if reached <= error), 0)
    return (good[place - 1], good[place]) if place else None


def _between(tried: Tried, coarse: tuple[float, float], fine: tuple[float, float], error: float) -> float:
    """Return where the power law through two runs meets `error`; their middle where that is one of them."""
    share = math.log(coarse[1] / error) / math.log(coarse[1] / max(fine[1], TINY))
    knob = coarse[0] * (fine[0] / coarse[0]) ** share
    return math.sqrt(coarse[0] * fine[0]) if _same_as_tried(tried, knob) else knob


def _beyond(tried: Tried, error: float) -> float:
    """Return where a power law leads from the nearest run to `error`.

    Its order is the documented one, corrected by the next run: the more, the further apart the two are. A run that
    takes no more steps than the other tells no order, and a finest one that takes no more than those before is left
    behind by a plainly finer setting; where outputs alone end the steps, tolerances begin to govern them at about the
    error that there is.
    """
    good, order = tried.sound(), tried.foretold
    is_finer = good[-1][1] > error
    (knob, here), *others = good[::-1] if is_finer else good
    for another, there in others[:1]:
        foretold, seen = order * math.log(another / knob), math.log(max(there, TINY) / max(here, TINY))
        doubt = (math.log(BOUNCE) / (SPREAD * foretold)) ** 2  # of what is seen against what is foretold
        if _takes_more(tried, min(another, knob), max(another, knob)):
            order *= max(min(0.5, 1.0 / order), (doubt + seen / foretold) / (doubt + 1.0))  # first order, at the least
    stays = is_finer and not tried.refines(knob)
    begins = min(knob, here) if is_finer and tried.method.kind == "adaptive" and _is_idle(tried, knob) else knob
    led = begins * (error / max(here, TINY)) ** (1.0 / order)
    return min(led, knob / _factor(tried)) if stays else led


def _takes_more(tried: Tried, fine: float, coarse: float) -> bool:
    """Whether a setting takes more steps than a coarser one: NEXT_TO_NONE is no difference."""
    return tried.records[fine].steps > (1.0 + NEXT_TO_NONE) * tried.records[coarse].steps


def _is_idle(tried: Tried, knob: float) -> bool:
    """Whether outputs alone end the steps."""
    return SAMPLES - 1 <= tried.records[knob].steps <= (1.0 + NEXT_TO_NONE) * (SAMPLES - 1)


def _is_vain(tried: Tried, knob: float, target: float) -> bool:
    """Whether the target asks for more than any setting can give that is left between the finest run and a failure.

    So it is where the law leads to a tolerance that failed or beyond, and where a setting is hardly finer than the
    finest run.
    """
    finest, _ = tried.sound()[-1]
    failed = [k for k in tried.knobs if k < finest and tried.method.kind == "adaptive"]
    wished = (1.0 + NEXT_TO_NONE) * _beyond(tried, target)
    beyond = bool(failed) and len(tried.good()) > 1 and wished <= max(failed) < knob
    return knob < finest and (beyond or (wished < knob and _is_close(tried, finest, knob)))


def _is_over(tried: Tried) -> bool:
    """Whether two refinements or more, PLAIN together, brought less than half of what first order promises.

    No more is promised whatever the documented order, for contacts that begin and end between steps leave no more.
    Refinements that take no more steps, as where outputs govern them, promise nothing; runs that lost their way tell
    nothing.
    """
    good = tried.sound()
    plainly = [place for place, (knob, _) in enumerate(good[:-2]) if knob >= PLAIN * good[-1][0]]
    if not plainly:
        return False
    (coarse, before), *later = good[plainly[-1] :]
    return _takes_more(tried, later[-1][0], coarse) and min(error for _, error in later) > STALLED * before


def _is_shown(tried: Tried) -> bool:
    """Whether the runs made are enough for a verdict: two in agreement, or ENOUGH levels of them."""
    agreeing = [error for _, error in tried.good() if error <= AGREEMENT]
    return len(agreeing) >= 2 or tried.levels() >= ENOUGH


def _support(runs: Runs, tried: Tried) -> None:
    """Make runs until there are ENOUGH levels: finer than the finest where work allows, else coarser, else between."""
    for _ in range(TRIES):
        done = [knob for knob in tried.knobs if tried.records[knob].status == "success"]
        if _is_shown(tried):
            return
        factor = _factor(tried)
        wanted = (min(done) / factor, max(done) * factor, math.sqrt(min(done) * max(done)))
        able = [k for k in wanted if _is_able(tried, k) and not _same_as_tried(tried, k)]
        if not able:
            return
        _try(runs, tried, able[0])


def _is_able(tried: Tried, knob: float) -> bool:
    """Whether a setting is within the bound on work and what can be typed, and no coarser one failed that is finer."""
    failed = [k for k in tried.knobs if tried.records[k].status != "success"]
    finest = min(k for k in tried.knobs if tried.records[k].status == "success")
    beyond = any(k <= knob for k in failed) if knob > finest else any(k >= knob and k < finest for k in failed)
    allowed = TIGHTEST <= knob <= coarsest(tried.method, tried.scene) and _steps(tried, knob) <= tried.most_steps
    return allowed and not beyond


def _try(runs: Runs, tried: Tried, knob: float) -> Record:
    settings = settings_at(tried.method, tried.scene, knob)
    run = runs.run(tried.scene, tried.engine, settings)
    record = against(tried.scene, run, tried.truth)
    tried.records[knob_of(settings)], tried.paths[knob_of(settings)] = record, run.path
    return record


def _same_as_tried(tried: Tried, knob: float) -> bool:
    return _typed(tried, knob) in tried.records


def _steps(tried: Tried, knob: float) -> float:
    """Return how many steps a setting takes: counted for a fixed step, foretold from the runs made for a tolerance.

    From the nearest run steps grow by the documented order, or as they did between the finest where that is faster;
    no finer run takes fewer.
    """
    if tried.method.kind == "fixed":
        return tried.scene.duration / knob
    done = sorted((k, r.steps) for k, r in tried.records.items() if r.status == "success" and r.steps)
    if not done:
        return 0.0
    known, steps = min(done, key=lambda run: abs(math.log(run[0] / knob)))
    foretold = steps * (known / knob) ** _growth(tried, done)
    return min([foretold, *(taken for finer, taken in done if finer <= knob)])


def _growth(tried: Tried, done: list[tuple[float, int]]) -> float:
    """Return the power of a tolerance by which steps grow, from runs (tolerance, steps), fine to coarse."""
    documented = 1.0 / tried.method.local_order
    finest, most = done[0]
    coarser, fewer = next((run for run in done if run[0] >= _factor(tried) * finest), done[0])
    return documented if coarser == finest else max(documented, math.log(most / fewer) / math.log(coarser / finest))


def _answer(tried: Tried, became: TargetResult) -> TargetResult:
    """Say what became of a target, from all the runs that were made in the end."""
    good = tried.good()
    truth = tried.truth
    record = next((r for r in _successes(tried) if r.error is not None and r.error.value <= became.target), None)
    if record is not None:
        return TargetResult(became.target, "reached", record)
    if isinstance(truth, Truth) and good:
        floor = next(r.error.floor for r in _successes(tried) if r.error is not None)
        if became.target < floor:
            return TargetResult(became.target, "unjudged", None, f"the truth judges no error below {floor:.1e}")
    if became.answer == "not-tried" and not _is_over(tried):
        return became
    best = min((error for _, error in good), default=None)
    reason = _last_words(tried) if best is None else f"its best is {best:.1e}; {_why_no_better(tried)}"
    return TargetResult(became.target, "not-reached", None, reason)


def _why_no_better(tried: Tried) -> str:
    """Say why the best run of a method is its best."""
    if tried.is_scattered():
        return "its runs are as far from one another"
    if tried.records[tried.knobs[-1]].status != "success":
        return "finer settings that were tried failed"
    return "finer settings do not help" if _is_over(tried) else "no setting that was tried does better"


def _successes(tried: Tried) -> list[Record]:
    return [tried.records[knob] for knob in tried.knobs if tried.records[knob].status == "success"]


def _last_words(tried: Tried) -> str:
    last = tried.records[tried.knobs[-1]]
    return last.message or last.status
