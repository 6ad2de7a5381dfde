"""Choose which settings of a method to run: the next run is the one that is worth most, by the convergence model.

A run is worth the odds that it reaches a target from within WINDOW, less what its steps cost. A target is given up
where no setting within the work limit has fair odds. Further runs follow only while the verdict is not settled: a
finer one, halfway to the finest setting where a plateau or a limit of its own may hide the law. A method is classified
as wrong only after a run plainly finer than all others, even beyond the work limit. Work is counted in steps, the same
for every engine, so that the choice does not depend on how busy a machine is. A run that is expected to take more than
MOST_SECONDS is not made either, but reported.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from cross_checks.judge import bounds
from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import Posterior, posterior
from cross_checks.judge.convergence.prediction import error_range, expected_log_error, odds_below, outcomes
from cross_checks.judge.verdict import Judgement, Point, above_rounding, judge, ladder_of
from cross_checks.judge.vocabulary import REFUSED, SILENT, Omitted, Verdict

PER_DECADE = 12  # settings that are considered
TOO_SMALL = "step-too-small"  # status of a method whose step size underflowed: a tighter tolerance fails, too


class Subject(Protocol):
    """What is searched: one method on one scene."""

    kind: str  # fixed | adaptive
    expected: float  # order of the error in the setting
    documented_order: float  # order that a verdict may expect
    local_order: int  # power of the step that a tolerance controls
    coarsest: float
    finest: float  # within the work limit, or the tightest tolerance
    duration: float  # s
    outputs: int  # intervals between output times
    most_steps: int
    why_no_truth: str

    def typed(self, knob: float) -> float:
        """Return the setting nearest to a wish that a user can type."""
        ...

    def run(self, knob: float) -> Point:
        """Return the run at a typed setting."""
        ...

    def gap(self, first: float, second: float) -> float:
        """Return the distance between two runs; NaN where unknown."""
        ...

    def facts(self) -> dict:
        """Return what else a ladder states: kind, order, reference, typical, uncertainty."""
        ...

    def reference(self, knob: float) -> float | None:
        """Return the error of a sound method of the same order at the same setting, of another package."""
        ...


@dataclass
class Search:
    """The runs of one method, and what they show."""

    subject: Subject
    points: dict[float, Point] = field(default_factory=dict)
    reference: tuple[float, float] | None = None  # setting and error of a reference method
    _shown: tuple[tuple, Posterior | None] = ((), None)

    @property
    def knobs(self) -> list[float]:
        """The settings that were run, coarse to fine."""
        return sorted(self.points, reverse=True)

    @property
    def good(self) -> list[Point]:
        """The runs that succeeded, coarse to fine."""
        return [self.points[knob] for knob in self.knobs if self.points[knob].ok]

    def shown(self) -> Posterior | None:
        """Return the posterior of the runs that succeeded; None without one."""
        state = (len(self.points), self.reference)
        if self._shown[0] != state:
            ladder = self._ladder(self.good, self._gaps())
            self._shown = state, None if ladder is None else posterior(ladder)
        return self._shown[1]

    def judgement(self) -> Judgement:
        """Return the verdict on all runs."""
        return self._with_price(self._judged([self.points[knob] for knob in self.knobs], self.shown()))

    def _with_price(self, judged: Judgement) -> Judgement:
        """Return a verdict that time alone left open with the time that a finer run would take."""
        if judged.verdict is not Verdict.NOT_SHOWN or not self.good:
            return judged
        finer = self.good[-1].knob / bounds.FINER[self.subject.kind]
        seconds = float(self.seconds(np.array([finer]))[0])
        is_dear = seconds > bounds.MOST_SECONDS and finer >= self.subject.finest
        return judged._replace(reason=f"{judged.reason}; a finer run would take {seconds:.2g} s") if is_dear else judged

    def _gaps(self) -> np.ndarray:
        good = self.good
        return np.array([[self.subject.gap(a.knob, b.knob) for b in good] for a in good])

    def _ladder(self, good: Sequence[Point], gaps: np.ndarray) -> Ladder | None:
        facts = self.subject.facts()
        if self.reference is not None:
            setting, error = self.reference
            facts |= {"reference": setting, "typical": math.log10(max(error, 1e-18)), "spread": 0.5}
        return ladder_of(good, gaps, **facts)

    def _judged(self, points: Sequence[Point], shown: Posterior | None) -> Judgement:
        return judge(points, shown, self.subject.documented_order, self.subject.why_no_truth)

    def try_(self, knob: float) -> Point:
        """Run a typed setting."""
        self.points[knob] = self.subject.run(knob)
        return self.points[knob]

    # --- targets

    def reach(self, targets: Sequence[float]) -> None:
        """Make runs until every target is reached from within its window, or has no fair odds.

        An error of t - u shows a target t, against a truth that is known to u; a target below u is not sought.
        """
        known = self.subject.facts()["uncertainty"]
        tries = {target - known: 0 for target in targets if target > known}
        while len(self.points) < bounds.MOST_RUNS:
            choice = self._best(tries)
            if choice is None:
                return
            knob, served = choice
            for target in served:
                tries[target] += 1
            self.try_(knob)

    def _best(self, tries: dict[float, int]) -> tuple[float, list[float]] | None:
        """Return the setting worth most and the targets that it serves; None where no run is worth its cost.

        `tries` counts the runs made for each target.
        """
        shown = self.shown()
        knobs = self._candidates()
        if shown is None or not len(knobs):
            return None
        runs = self._odds_to_run(knobs)
        steps = np.log10(np.maximum(self.steps(knobs), 1.0))
        worth, able, served = np.zeros(len(knobs)), np.zeros(len(knobs), dtype=bool), []
        within_work = [point for point in self.good if point.steps <= 1.01 * self.subject.most_steps]
        for target in tries:
            reaching = [point for point in within_work if point.error is not None and point.error <= target]
            at_most = runs * odds_below(shown, knobs, target)
            within = at_most - runs * odds_below(shown, knobs, target / bounds.AIM)
            if reaching:
                cheapest = reaching[0]
                cheaper = (knobs > cheapest.knob) & (10.0**steps < 0.8 * max(cheapest.steps, 1))
                gain = np.where(cheaper, within, 0.0)
                if (cheapest.error or 0.0) >= target / bounds.WINDOW or gain.max() < bounds.LIKELY or tries[target] > 2:
                    continue
                worth += gain
                able |= gain >= bounds.LIKELY
            else:
                if at_most.max() < (bounds.FAIR if tries[target] < 3 else bounds.LIKELY) or tries[target] > 4:
                    continue
                worth += within if served else within + bounds.BELOW * (at_most - within)  # the loosest target leads
                able |= at_most >= 0.5 * at_most.max()
            served.append(target)
        if not served:
            return None
        best = int(np.argmax(np.where(able, worth - bounds.PRICE * steps, -np.inf)))
        near = [t for t in served if odds_below(shown, knobs[best : best + 1], t)[0] > bounds.FAIR]
        return float(knobs[best]), near or served[:1]

    def _candidates(self) -> np.ndarray:
        """Return typed settings within the work limit that were not run (n,), coarse to fine."""
        subject = self.subject
        count = max(2, int(PER_DECADE * math.log10(subject.coarsest / subject.finest)))
        wished = np.geomspace(subject.coarsest, subject.finest, count)
        typed = np.array(sorted({subject.typed(float(knob)) for knob in wished} - set(self.points), reverse=True))
        return typed[self._within_work(typed)]

    def steps(self, knobs: np.ndarray) -> np.ndarray:
        """Return how many steps settings take (n,): counted for a fixed step, extrapolated for a tolerance.

        From the next coarser run steps grow by the documented order, or as between the finest runs if that is faster.
        """
        if self.subject.kind == "fixed":
            return self.subject.duration / knobs
        done = [(point.knob, point.steps) for point in self.good if point.steps]
        if not done:
            return np.zeros(len(knobs))
        known, steps = (np.array(each, dtype=float) for each in zip(*done, strict=True))
        growth = 1.0 / self.subject.local_order
        plainly = np.flatnonzero(known >= 10.0 * known[-1])
        if len(plainly):
            seen = math.log(steps[-1] / steps[plainly[-1]]) / math.log(known[plainly[-1]] / known[-1])
            growth = max(growth, seen)
        coarser = np.maximum(np.sum(known[None, :] >= knobs[:, None], axis=1) - 1, 0)  # runs go from coarse to fine
        predicted = steps[coarser] * (known[coarser] / knobs) ** growth
        finer = np.where(known <= knobs[:, None], steps, np.inf).min(axis=1)  # no finer run takes fewer
        return np.maximum(np.minimum(predicted, finer), min(self.subject.outputs, steps.min()))  # each output ends one

    def seconds(self, knobs: np.ndarray) -> np.ndarray:
        """Return how long the loops of settings are expected to take (n,), s: steps at the slowest pace so far."""
        known = self.steps(np.array([point.knob for point in self.good]))  # of a fixed step where none is reported, too
        return self.steps(knobs) * max((p.seconds / n for p, n in zip(self.good, known, strict=True) if n), default=0.0)

    def _within_work(self, knobs: np.ndarray, allowance: float = 1.0) -> np.ndarray:
        """Return whether settings (n,) are within `allowance` times the limits on steps and seconds."""
        few = self.steps(knobs) <= 1.01 * allowance * self.subject.most_steps
        return few & (self.seconds(knobs) <= allowance * bounds.MOST_SECONDS)

    def _odds_to_run(self, knobs: np.ndarray) -> np.ndarray:
        """Return the odds (n,) that settings run: less beyond a failure, and between a failure and the nearest run."""
        good = np.array([point.knob for point in self.good])
        odds = np.ones(len(knobs))
        for point in self.points.values():
            if point.ok:
                continue
            beyond = knobs <= point.knob if point.knob < good.min() else knobs >= point.knob
            inside = good.min() < point.knob < good.max()
            if inside:
                beyond = np.abs(np.log(knobs / point.knob)) < math.log(1.2)
            nearest = good[np.argmin(np.abs(np.log(good / point.knob)))]
            share = np.log(knobs / nearest) / math.log(point.knob / nearest)  # 0 at the run, 1 at the failure
            between = np.clip(1.0 - share**2, 0.05, 1.0)
            leap = 0.3 if self.subject.kind == "fixed" else 0.05
            odds *= np.where(beyond, leap, 1.0 if inside else np.where(share > 0.0, between, 1.0))
        return odds

    # --- the first run and the verdict

    def begin(self, first: float) -> bool:
        """Find a first setting at which the method runs; return whether there is one.

        Finer settings follow where it is refused or fails: steps in growing leaps, tolerances in the middle and at both
        ends.
        """
        finest = self.subject.finest
        tightest = math.inf  # tolerances above which steps become too small
        for wish in self._first(max(first, finest)):
            knob = self.subject.typed(wish)
            if knob in self.points or (tightest < math.inf and knob <= tightest):
                continue
            point = self.try_(knob)
            if point.ok:
                return True
            if point.status in REFUSED and "step" not in point.message:
                return False
            tightest = knob if point.status == TOO_SMALL else tightest
        return False

    def _first(self, first: float) -> list[float]:
        finest, coarsest = self.subject.finest, self.subject.coarsest
        if self.subject.kind == "adaptive":
            return [first, math.sqrt(first * finest), finest, math.sqrt(first * coarsest), coarsest]
        wishes, factor = [first], 4.0
        while wishes[-1] > 4.0 * finest:
            wishes.append(max(wishes[-1] / factor, finest))
            factor **= 2.0
        return wishes

    def settle(self) -> Judgement:
        """Make runs until the verdict is settled or no setting remains; return it."""
        confirmed = False
        while True:
            judged = self.judgement()
            if judged.verdict in SILENT and self.good and not confirmed:
                confirmed = True
                finer = self.subject.typed(self.good[-1].knob / bounds.FINER[self.subject.kind])
                if finer not in self.points and self._is_able(finer, bounds.FINER["fixed"]):
                    self.try_(finer)
                    continue
            if judged.verdict is Verdict.NOT_SHOWN:
                if self._has_new_reference():
                    continue
                knob = self._settling() if len(self.points) < self._most_runs() else None
                if knob is not None:
                    self.try_(knob)
                    continue
            return judged

    def _most_runs(self) -> int:
        """Return how many runs a verdict is worth: more where a failure is likely and not certain."""
        shown = self.shown()
        is_lost = self.reference is not None and (self.good[-1].error or 0.0) > bounds.RESOLVED
        if shown is None or (
            not is_lost and (len(shown.ladder) < bounds.LEVELS or shown.weights["right"] < 1.0 - bounds.DOUBTFUL)
        ):
            return bounds.MOST_RUNS
        return bounds.MOST_RUNS // 2

    def _settling(self) -> float | None:
        """Return the setting that is most informative: the middle of the widest gap; None where none remains.

        Where rounding hides the law, the coarse half shows it; where runs do not follow it, the fine half.
        """
        good = np.array([point.knob for point in self.good])
        knobs = self._candidates()
        if not len(good) or not len(knobs):
            return None
        apart = np.abs(np.log(knobs)[:, None] - np.log(np.array(self.knobs))).min(axis=1)
        knobs = knobs[
            (apart > math.log(bounds.FINER[self.subject.kind]) / 4.0) & (self._odds_to_run(knobs) >= bounds.LIKELY)
        ]
        if not len(knobs):
            return None
        middle, shown = math.sqrt(good.min() * good.max()), self.shown()
        wished = knobs < good.max()
        if shown is not None and len(shown.ladder) > 1:
            best = above_rounding(shown.ladder)
            if best < len(shown.ladder) - 1:
                wished = knobs > shown.ladder.settings[best]
            elif shown.weights["right"] < 1.0 - bounds.DOUBTFUL:
                wished = knobs < middle
        knobs = knobs[wished] if wished.any() else knobs
        ends = [self.subject.finest] if self.subject.kind == "adaptive" else []  # a tolerance's steps are extrapolated
        apart = np.abs(np.log(knobs)[:, None] - np.log(np.array([*self.knobs, *ends]))).min(axis=1)
        return float(knobs[int(np.argmax(apart))])

    def _is_able(self, knob: float, allowance: float) -> bool:
        """Whether a setting is within the work limit, and no failure lies between it and the runs."""
        knobs = np.array([knob])
        return bool(self._within_work(knobs, allowance)[0] and self._odds_to_run(knobs)[0] >= bounds.LIKELY)

    def _has_new_reference(self) -> bool:
        """Run a reference method where runs are as far off as motions go; return whether there is one."""
        good = self.good
        if self.reference is not None or not good or not (good[-1].error or 0.0) > bounds.RESOLVED:
            return False
        error = self.subject.reference(good[-1].knob)
        self.reference = None if error is None else (good[-1].knob, error)
        return error is not None

    # --- what runs would show

    def _foreseen(self, knob: float) -> Iterator[tuple[float, Judgement, Posterior]]:
        """Yield the odds of each hypothesis and the verdict on all runs and the one that it expects at a setting."""
        shown, good, gaps = self.shown(), self.good, self._gaps()
        assert shown is not None
        errors = np.array([math.nan if point.error is None else point.error for point in good])
        if good[-1].error is None:
            errors = 10.0 ** expected_log_error(shown, np.array([point.knob for point in good]))
        steps, last = int(self.steps(np.array([knob]))[0]), good[-1]
        rounding = last.rounding * steps / max(last.steps, 1)
        for odds, error, apart in outcomes(shown, knob, errors, gaps):
            known = None if last.error is None else error
            point = Point(f"{knob:g}", knob, "success", "", known, steps, rounding)
            every = [*good, point]
            order = np.argsort([-one.knob for one in every])
            wider = np.pad(gaps, (0, 1))
            wider[-1, :-1] = wider[:-1, -1] = apart
            points = [every[k] for k in order]
            ladder = self._ladder(points, wider[np.ix_(order, order)])
            assert ladder is not None
            then = posterior(ladder)
            yield odds, self._judged(points, then), then

    def omitted(self, target: float) -> Omitted | None:
        """Return what the coarsest run would show that reaches a target more likely than not, else the likeliest one.

        Of settings that were not run, beyond the work limit as well; None without a successful run.
        """
        shown = self.shown()
        if shown is None:
            return None
        least = self.subject.finest if self.subject.kind == "adaptive" else 1e-8 * self.good[-1].knob
        knobs = np.geomspace(self.subject.coarsest, least, 121)
        odds = self._odds_to_run(knobs) * odds_below(shown, knobs, target)
        place = int(np.argmax(odds >= min(0.5, odds.max())))
        knob = float(knobs[place])
        low, middle, high = error_range(shown, knob)
        verdicts = {self.judgement().verdict: shown.weights["plateau"]}
        for share, judged, _ in self._foreseen(knob):
            verdicts[judged.verdict] = verdicts.get(judged.verdict, 0.0) + share
        verdict = max(verdicts, key=lambda word: verdicts[word])
        steps, seconds = (float(cost(knobs[place : place + 1])[0]) for cost in (self.steps, self.seconds))
        return Omitted(knob, steps, seconds, float(odds[place]), middle, (low, high), verdict, verdicts[verdict])
