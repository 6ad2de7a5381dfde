"""The verdict on a method: what the posterior of its runs states, in one word, one sentence and its odds."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cross_checks.judge.bounds import AGREEMENT, DOUBTFUL, FAILING, LEVELS, RESOLVED, SCATTER
from cross_checks.judge.convergence import calibration
from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import ROUNDED, Posterior, posterior
from cross_checks.judge.vocabulary import REFUSED, Verdict
from cross_checks.records.numbers import of_scene
from cross_checks.truths.truth import ONE_FIGURE

BLOWN_UP = frozenset({"non-finite", "reset"})


@dataclass(frozen=True)
class Point:
    """One run of a method as a verdict reads it."""

    setting: str  # as a reader would type it: step=0.001
    knob: float  # step (s) or relative tolerance
    status: str
    message: str = ""
    error: float | None = None  # distance from the truth over the scene's scales; None without a truth
    steps: int = 0
    rounding: float = 0.0  # what rounding may add to the error

    @property
    def ok(self) -> bool:
        return self.status == "success"


class Judgement(NamedTuple):
    """A verdict with its sentence and the odds that it is false."""

    verdict: Verdict
    reason: str
    odds: float | None = None  # None where no probability is involved


def judge(
    points: Sequence[Point], shown: Posterior | None, documented: float = 1.0, why_no_truth: str = ""
) -> Judgement:
    """Return the verdict on runs from coarse to fine; `shown` is the posterior of those that succeeded.

    `documented` is the order that the method must show to be called converging: less than half of it is too little.
    """
    good = [point for point in points if point.ok]
    if not good or shown is None:
        return _without_success(points)
    judged = _without_truth(shown, why_no_truth) if good[-1].error is None else _by_error(good, shown, documented)
    last = points[-1]
    if last.ok or last.status in REFUSED:
        return judged
    return judged._replace(reason=f"{judged.reason}; {last.setting} ends with {last.status}: {last.message}")


def _by_error(good: Sequence[Point], shown: Posterior, documented: float, levels: int = 0) -> Judgement:
    """Return the verdict by errors. `levels`: number of successful levels, those that rounding explains included."""
    ladder = shown.ladder
    levels = max(levels, len(ladder))
    place = above_rounding(ladder)
    if place < len(ladder) - 1:
        coarser = [point for point in good if point.knob >= ladder.settings[place]]
        judged = _by_error(coarser, posterior(ladder.take(slice(place + 1))), documented, levels)
        return judged._replace(reason=f"{judged.reason}; rounding may explain the errors of finer runs")
    error, uncertainty = float(ladder.errors[-1]), ladder.uncertainty
    last = at_error(good, error).setting
    bar = AGREEMENT + uncertainty  # a limit farther from the truth is off the motion by more than AGREEMENT
    limit, stall = shown.odds_of_limit(bar), shown.odds_of_stall(bar)
    slow = shown.odds_of_order_below(0.5 * min(documented, 1.0))  # of first order, or of what is documented if less
    if error + uncertainty <= AGREEMENT:
        return _agreement(good, last, error, limit + stall)
    if error <= max(AGREEMENT, ONE_FIGURE * uncertainty):
        return Judgement(Verdict.BELOW_TRUTH, f"{error:.1e} at {last}; the truth is known to {uncertainty:.1e}")
    wrong = _wrong(last, shown, limit, stall + shown.weights["right"] * slow) if len(ladder) >= LEVELS else None
    if wrong is not None:
        return wrong
    return _approach(last, shown, documented, slow, levels)


def above_rounding(ladder: Ladder) -> int:
    """Return the level after which rounding explains all errors: the best of those that it explains, else the last."""
    allowed = ROUNDED * ladder.rounding
    first = len(ladder)
    while first > 0 and ladder.errors[first - 1] <= allowed[first - 1]:
        first -= 1
    if first >= len(ladder) or ladder.errors[-1] <= AGREEMENT:
        return len(ladder) - 1
    return first + int(np.argmin(ladder.errors[first:]))


def at_error(good: Sequence[Point], error: float) -> Point:
    """Return the finest run of this error: that of a level is its largest, which need not be its finest run's."""
    return next((point for point in reversed(good) if point.error == error), good[-1])


def _agreement(good: Sequence[Point], last: str, error: float, failing: float) -> Judgement:
    if len(good) < 2:
        return Judgement(Verdict.NOT_SHOWN, f"only {last} reaches {error:.1e}: one run shows no convergence")
    if failing < DOUBTFUL:
        return Judgement(Verdict.AGREES, f"{error:.1e} from the truth at {last}", _capped(failing))
    return Judgement(Verdict.NOT_SHOWN, f"{error:.1e} at {last}, and odds of {failing:.2g} that this is chance")


def _wrong(last: str, shown: Posterior, limit: float, stall: float) -> Judgement | None:
    """Return the classification as wrong-limit, lost or diverged where its odds suffice."""
    ladder, error = shown.ladder, of_scene(float(shown.ladder.errors[-1]))
    if stall + limit <= FAILING or ladder.is_falling:
        return None
    odds, best = _capped(1.0 - stall - limit), float(np.min(ladder.errors))
    if limit > stall:
        own = f"its own limit is {of_scene(shown.limit_distance)} from the truth"
        return Judgement(Verdict.WRONG_LIMIT, f"{error} at {last}: {own}", odds)
    if best <= AGREEMENT:
        return Judgement(Verdict.LOST, f"{error} at {last}, after {of_scene(best)} at a coarser setting", odds)
    return Judgement(Verdict.DIVERGED, f"the error does not fall: still {error} at {last}", odds)


def _approach(last: str, shown: Posterior, documented: float, slow: float, levels: int) -> Judgement:
    """Return whether errors approach zero on more `levels` than LEVELS, the unknowns: as many runs fit any law."""
    ladder, error = shown.ladder, float(shown.ladder.errors[-1])
    least = max(error / SCATTER, ROUNDED * float(ladder.rounding[-1]))
    doubts = {
        "that it converges to another limit": shown.odds_of_limit(error / SCATTER),
        "that errors stall": shown.odds_of_stall(least),
        "that outputs or events set all steps so far": shown.weights["plateau"],
        "that the error hardly falls": (shown.weights["right"] + shown.weights["limit"]) * slow,
    }
    odds = sum(doubts.values())
    is_best = error <= SCATTER * float(np.min(ladder.errors))
    if levels > LEVELS <= len(ladder) and error <= RESOLVED and is_best and odds < DOUBTFUL:
        pace = f"falling with order {shown.order:.2g}"
        pace += f", below half of {documented:.2g}" if shown.order < 0.5 * documented else ""
        return Judgement(Verdict.CONVERGING, f"{error:.1e} at {last}, {pace}", _capped(odds))
    what, most = max(doubts.items(), key=lambda item: item[1])
    why = f"odds of {most:.2g} {what}" if odds >= DOUBTFUL else "too few levels, or too far off, to show an approach"
    why = why if is_best else f"a coarser setting is better, {np.min(ladder.errors):.1e}"
    return Judgement(Verdict.NOT_SHOWN, f"still {error:.1e} off at {last}: {why}")


def _without_truth(shown: Posterior, why: str) -> Judgement:
    if len(shown.ladder) >= LEVELS and shown.weights["right"] > 1.0 - DOUBTFUL:
        last = shown.ladder.gaps[-2, -1]
        if last <= RESOLVED:
            return Judgement(Verdict.CONVERGING, f"to a limit of its own, the last gap is {last:.1e}. No truth: {why}")
    return Judgement(Verdict.NOT_SHOWN, f"no convergence shown, and no truth to compare with: {why}")


def _without_success(points: Sequence[Point]) -> Judgement:
    """Return the verdict where no run succeeded.

    A priori, half of such methods fail at every setting, and half at a share of settings between 0 and 0.5. After
    LEVELS failures the odds that another setting runs are 0.03; after two they are 0.08, more than 1 - FAILING.
    """
    if not points:
        return Judgement(Verdict.NOT_SHOWN, "no run was made")
    refused = [point for point in points if point.status in REFUSED]
    if len(refused) == len(points):
        return Judgement(Verdict(refused[-1].status), refused[-1].message)
    last = next(point for point in reversed(points) if point.status not in REFUSED)
    if last.status in (Verdict.TIMEOUT, Verdict.CRASHED, Verdict.OUT_OF_MEMORY):
        return Judgement(Verdict(last.status), f"{last.setting}: {last.message}")
    if len(points) < LEVELS:
        few = f"{len(points)} of at least {LEVELS} settings were run"
        return Judgement(Verdict.NOT_SHOWN, f"{last.setting}: {last.status}: {last.message}; {few}")
    verdict = Verdict.DIVERGED if last.status in BLOWN_UP else Verdict.FAILED
    return Judgement(verdict, f"{last.setting}: {last.status}: {last.message}")


def _capped(odds: float) -> float:
    """Return odds no smaller than the calibration supports: 3/n after n methods without a failure."""
    return max(odds, 3.0 / sum(family["methods"] for family in calibration().values()))
