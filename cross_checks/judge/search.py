"""Choose which settings of a method to run: the next run is the one that is worth most, by the convergence model.

A run is worth the odds that it reaches a target from within WINDOW, less what its steps cost. An error below the
window costs more than need be: it is worth LIKELY, the odds from which a cheaper run is tried. A target is given
up where no setting within the work limit may reach it. Further runs follow only while the verdict is not settled: of
the settings that may show the law, finer ones where a plateau or a limit of its own may hide it, the one that shows
most for its cost. A method is classified as wrong only after a run plainly finer than all others, even beyond the work
limit. Work is counted in steps, the same for every engine, so that the choice does not depend on how busy a machine is.
A limit of processor time may end the search for a target as well; where the verdict within it is open or wrong, nothing
is limited, unless a documented weakness explains it.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from cross_checks.judge import bounds
from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import Posterior, posterior
from cross_checks.judge.convergence.prediction import error_range, odds_below
from cross_checks.judge.verdict import Judgement, Point, above_rounding, judge
from cross_checks.judge.vocabulary import REFUSED, SILENT, Omitted, Verdict

PER_DECADE = 12  # settings that are considered
TOO_SMALL = "step-too-small"  # status of a method whose step size underflowed: a tighter tolerance fails, too


class Search(ABC):
    """The runs of one method on one scene, and what they show. A subclass states the attributes and makes the runs."""

    kind: str  # fixed | adaptive
    documented_order: float  # order that a verdict may expect
    local_order: int  # power of the step that a tolerance controls
    coarsest: float
    finest: float  # within the work limit, or the tightest tolerance
    duration: float  # s
    outputs: int  # intervals between output times
    most_steps: int
    why_no_truth: str
    is_exempt: bool = False  # a documented weakness explains a failure: no run takes long for the verdict alone

    def __init__(self) -> None:
        self.points: dict[float, Point] = {}  # by setting
        self.reference: tuple[float, float] | None = None  # setting and error of a reference method
        self._computed: dict[tuple, Any] = {}  # from the runs at some time

    @abstractmethod
    def typed(self, knob: float) -> float:
        """Return the setting nearest to a wish that a user can type."""

    @abstractmethod
    def run(self, knob: float) -> Point:
        """Return the run at a typed setting."""

    @abstractmethod
    def gap(self, first: float, second: float) -> float:
        """Return the distance between two runs; NaN where unknown."""

    @abstractmethod
    def facts(self) -> dict:
        """Return what else a ladder states: kind, order, reference, typical, uncertainty."""

    @abstractmethod
    def reference_error(self, knob: float) -> float | None:
        """Return the error of a sound method of the same order at the same setting, of another package."""

    def affordable(self) -> float:
        """Return the most steps of a run that serves a target alone."""
        return math.inf

    def seconds(self, steps: float) -> float | None:
        """Return the processor time (s) of so many steps; None where no run shows it."""
        return None

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
        return self._once("shown", self._posterior)

    def verdict(self) -> Judgement:
        """Return the verdict on all runs."""
        points = [self.points[knob] for knob in self.knobs]
        return self._once("verdict", lambda: judge(points, self.shown(), self.documented_order, self.why_no_truth))

    def _once[Answer](self, what: str, compute: Callable[[], Answer]) -> Answer:
        """Return what was computed from the same runs before, else what `compute` returns."""
        state = what, len(self.points), self.reference
        if state not in self._computed:
            self._computed[state] = compute()
        return self._computed[state]

    def _posterior(self) -> Posterior | None:
        good, facts = self.good, self.facts()
        if not good:
            return None
        if self.reference is not None:
            setting, error = self.reference
            facts |= {"reference": setting, "typical": math.log10(max(error, 1e-18)), "spread": 0.5}
        gaps = np.array([[self.gap(a.knob, b.knob) for b in good] for a in good])
        return posterior(Ladder.of([(p.knob, p.error, p.steps, p.rounding) for p in good], gaps, **facts))

    def try_(self, knob: float) -> Point:
        """Run a typed setting."""
        self.points[knob] = self.run(knob)
        return self.points[knob]

    # --- targets

    def reach(self, targets: Sequence[float]) -> None:
        """Make runs until every target is reached from within its window, or has no fair odds.

        An error of t - u shows a target t, against a truth that is known to u; a target below u is not sought.
        """
        known = self.facts()["uncertainty"]
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

        `tries` counts the runs for each target.
        """
        shown, knobs = self.shown(), self._candidates()
        if shown is None or not len(knobs := knobs[self.steps(knobs) <= self.affordable()]):
            return None
        runs = self._odds_to_run(knobs)
        steps = np.log10(np.maximum(self.steps(knobs), 1.0))
        worth, able, served = np.zeros(len(knobs)), np.zeros(len(knobs), dtype=bool), []
        within_work = [point for point in self.good if point.steps <= 1.01 * self.most_steps]
        goals = np.array([*tries])[:, None]
        below = runs * odds_below(shown, knobs, np.concatenate([goals, goals / bounds.WINDOW]))  # and below the windows
        for target, at_most, beneath in zip(tries, *np.split(below, 2), strict=True):
            is_tried, within = tries[target] >= bounds.LEVELS, at_most - beneath
            reaching = [point for point in within_work if point.error is not None and point.error <= target]
            if reaching:
                cheapest = reaching[0]
                cheaper = (knobs > cheapest.knob) & (10.0**steps < 0.8 * max(cheapest.steps, 1))
                gain = np.where(cheaper, within, 0.0)
                if (cheapest.error or 0.0) >= target / bounds.WINDOW or gain.max() < bounds.LIKELY or is_tried:
                    continue
                worth += gain
                able |= gain >= bounds.LIKELY
            else:
                least = bounds.LIKELY if is_tried else bounds.DOUBTFUL
                if at_most.max() < least or tries[target] > bounds.LEVELS + 1:
                    continue
                worth += within if served else within + bounds.LIKELY * (at_most - within)  # the loosest target leads
                able |= at_most >= 0.5 * at_most.max()
            served.append(target)
        if not served:
            return None
        best = int(np.argmax(np.where(able, worth - bounds.DOUBTFUL * steps, -np.inf)))
        near = [t for t in served if odds_below(shown, knobs[best : best + 1], t)[0] > bounds.DOUBTFUL]
        return float(knobs[best]), near or served[:1]

    def _candidates(self) -> np.ndarray:
        """Return typed settings within the work limit that were not run (n,), coarse to fine."""
        count = max(2, int(PER_DECADE * math.log10(self.coarsest / self.finest)))
        wished = np.geomspace(self.coarsest, self.finest, count)
        typed = np.array(sorted({self.typed(float(knob)) for knob in wished} - set(self.points), reverse=True))
        return typed[self.steps(typed) <= 1.01 * self.most_steps] if len(typed) else typed

    def steps(self, knobs: np.ndarray) -> np.ndarray:
        """Return how many steps settings take (n,): counted for a fixed step, extrapolated for a tolerance.

        From the next coarser run steps grow by the documented order, or as between the finest runs if that is faster.
        """
        if self.kind == "fixed":
            return self.duration / knobs
        done = [(point.knob, point.steps) for point in self.good if point.steps]
        if not done:
            return np.zeros(len(knobs))
        known, steps = (np.array(each, dtype=float) for each in zip(*done, strict=True))
        growth = 1.0 / self.local_order
        plainly = np.flatnonzero(known >= 10.0 * known[-1])
        if len(plainly):
            seen = math.log(steps[-1] / steps[plainly[-1]]) / math.log(known[plainly[-1]] / known[-1])
            growth = max(growth, seen)
        coarser = np.maximum(np.sum(known[None, :] >= knobs[:, None], axis=1) - 1, 0)  # runs go from coarse to fine
        predicted = steps[coarser] * (known[coarser] / knobs) ** growth
        finer = np.where(known <= knobs[:, None], steps, np.inf).min(axis=1)  # no finer run takes fewer
        return np.maximum(np.minimum(predicted, finer), min(self.outputs, steps.min()))  # each output ends one

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
            between = np.clip(1.0 - share**2, 1.0 - bounds.FAILING, 1.0)
            leap = bounds.LIKELY if self.kind == "fixed" else 1.0 - bounds.FAILING
            odds *= np.where(beyond, leap, 1.0 if inside else np.where(share > 0.0, between, 1.0))
        return odds

    # --- the first run and the verdict

    def begin(self, first: float) -> bool:
        """Find a first setting at which the method runs; return whether there is one.

        Finer settings follow where it is refused or fails: steps in growing leaps, tolerances in the middle and at both
        ends. After LEVELS failures another setting hardly runs, and is tried only within what a target is worth.
        """
        finest = self.finest
        tightest = math.inf  # tolerances above which steps become too small
        for wish in self._first(max(first, finest)):
            knob = self.typed(wish)
            if knob in self.points or (tightest < math.inf and knob <= tightest):
                continue
            failed = [one for one in self.points.values() if one.status not in REFUSED]
            if len(failed) >= bounds.LEVELS and self.steps(np.array([knob]))[0] > self.affordable():
                return False
            point = self.try_(knob)
            if point.ok:
                return True
            if point.status in REFUSED and "step" not in point.message:
                return False
            tightest = knob if point.status == TOO_SMALL else tightest
        return False

    def _first(self, first: float) -> list[float]:
        finest, coarsest = self.finest, self.coarsest
        if self.kind == "adaptive":
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
            judged, knob = self.verdict(), None
            if judged.verdict in SILENT and self.good and not confirmed:
                confirmed, knob = True, self._plainly_finer()
            elif judged.verdict is Verdict.NOT_SHOWN:
                if self._has_new_reference():
                    continue
                knob = self._settling()
            if knob is None:
                return judged
            self.try_(knob)

    def _plainly_finer(self) -> float | None:
        """Return a setting that confirms a failure, beyond the work limit if need be; None where none will run."""
        knob = self.typed(self.good[-1].knob / bounds.FINER[self.kind])
        steps, odds = self.steps(np.array([knob]))[0], self._odds_to_run(np.array([knob]))[0]
        most = self.affordable() if self.is_exempt else 1.01 * bounds.FINER["fixed"] * self.most_steps
        is_able = steps <= most and odds >= bounds.LIKELY
        return knob if is_able and knob not in self.points else None

    def _settling(self) -> float | None:
        """Return the setting that is most informative for its cost, in the widest gap; None where none remains.

        A run shows more the farther it is from all others, up to a setting that is plainly finer.
        Where rounding hides the law, the coarse half shows it; where runs do not follow it, the fine half. Fewer runs
        are tried where they follow it, and where a reference method shows that the motion is not resolved.
        """
        good, knobs, shown = np.array([point.knob for point in self.good]), self._candidates(), self.shown()
        if shown is None or not len(knobs):
            return None
        follows = shown.weights["right"] >= 1.0 - bounds.DOUBTFUL
        unresolved = self.reference is not None and (self.good[-1].error or 0.0) > bounds.RESOLVED
        needs_fewer = unresolved or (follows and len(shown.ladder) >= bounds.LEVELS)
        if len(self.points) >= bounds.MOST_RUNS // (1 + needs_fewer):
            return None
        apart = np.abs(np.log(knobs)[:, None] - np.log(np.array(self.knobs))).min(axis=1)
        knobs = knobs[(apart > math.log(bounds.FINER[self.kind]) / 4.0) & (self._odds_to_run(knobs) >= bounds.LIKELY)]
        if not len(knobs):
            return None
        best, wished = above_rounding(shown.ladder), knobs < good.max()
        if best < len(shown.ladder) - 1:
            wished = knobs > shown.ladder.settings[best]
        elif len(shown.ladder) > 1 and not follows:
            wished = knobs < math.sqrt(good.min() * good.max())
        cheap = self.steps(knobs) <= self.affordable()
        if self.is_exempt and not cheap.any():
            return None
        knobs = next((knobs[chosen] for chosen in (wished & cheap, cheap, wished) if chosen.any()), knobs)
        ends = [self.finest] if self.kind == "adaptive" else []  # a tolerance's steps are extrapolated
        apart = np.abs(np.log(knobs)[:, None] - np.log(np.array([*self.knobs, *ends]))).min(axis=1)
        shows = np.minimum(apart / math.log(bounds.FINER[self.kind]), 1.0)
        return float(knobs[int(np.argmax(shows - bounds.DOUBTFUL * np.log10(np.maximum(self.steps(knobs), 1.0))))])

    def _has_new_reference(self) -> bool:
        """Run a reference method where runs are as far off as motions go; return whether there is one."""
        good = self.good
        if self.reference is not None or not good or not (good[-1].error or 0.0) > bounds.RESOLVED:
            return False
        error = self.reference_error(good[-1].knob)
        self.reference = None if error is None else (good[-1].knob, error)
        return error is not None

    # --- what a run would show

    def omitted(self, target: float) -> Omitted | None:
        """Return what the coarsest run would show that reaches a target more likely than not, else the likeliest one.

        Of settings that were not run, beyond the work limit as well; None without a successful run.
        """
        shown = self.shown()
        if shown is None:
            return None
        least = self.finest if self.kind == "adaptive" else 1e-8 * self.good[-1].knob
        knobs = np.geomspace(self.coarsest, least, 121)
        odds = self._odds_to_run(knobs) * odds_below(shown, knobs, target)
        place = int(np.argmax(odds >= min(bounds.EVEN, odds.max())))
        knob = float(knobs[place])
        low, middle, high = error_range(shown, knob)
        steps = float(self.steps(knobs[place : place + 1])[0])
        return Omitted(knob, steps, float(odds[place]), middle, (low, high), self.seconds(steps))
