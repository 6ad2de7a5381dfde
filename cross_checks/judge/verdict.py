"""The verdict on a method: a pure function of its runs on a scene.

Criteria, in the order in which they are asked. e is a run's error over the scene's scales, u the truth's uncertainty,
d the distance of the finest run from the method's own limit. All runs count, from coarse to fine.

    cannot       every run was refused, with reasons
    agrees       from some run on, all finer ones have e <= AGREEMENT: at least two of them, or one to which the error
                 fell at half the documented order or faster
    lost         some run had e <= AGREEMENT, and a finer one has not: accuracy was reached and lost again
    below-truth  the finest run has e < 30 u: better than the truth is known
    wrong-limit  d < SETTLED e: the method's own limit is not the truth. d follows from the gaps between the last three
                 runs, measured by the very function that measures e, and from the order at which they shrink
    converging   over the last two refinements e fell at least at half the documented order, to 0.1 or less
    diverged     the finest runs blew up, or e does not fall, or all settings of a wide range take the same steps.
                 A rise within the BOUNCE is none where e fell by more since a setting PLAIN times as coarse
    not-shown    too few runs within the bound on work

That an error does not fall accuses nobody where another engine's method of the same order, the control, is as far off
at the same setting. Nor does what rounding may leave after a run's steps, as after thousands in single precision: runs
whose error is no larger tell of the arithmetic and are set aside (`above_rounding`). Nor does a limit of its own or an
error that does not fall, where the appeal, a run plainly finer than those that are asked of all, leaves at most STALLED
of the error.

The documented order is no more than first where forces jump or bend between the steps of a method that locates no
events. Convergence is read from refinements. A run that takes no more steps than a coarser one, as where outputs end
the steps, refines nothing: such runs are one level, for which the largest of their errors stands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from scipy.optimize import root_scalar

from cross_checks.judge.vocabulary import AGREEMENT, REFUSED, WRONG, Verdict
from cross_checks.truth import MARGIN

SETTLED = 0.1  # of the error: a limit this close to the finest run, and the truth is elsewhere
SHRINKING = 0.5  # the gap before, at least: less would not tell a limit
RESOLVED = 0.1  # of the scene: an error beyond is no approach
STALLED = 0.5  # of the error before a plain refinement: an error beyond, and refining does not help
BOUNCE = 2.718  # factor by which errors of neighbouring settings differ from a power law
PLAIN = 4.0  # factor to a setting so much finer that a method of first order shows its progress beyond the bounce
MOST_ORDER = 20.0  # that gaps are asked for
WIDE = 1e3  # factor between the coarsest and the finest setting: one that rules the steps at all does so over as much


STAYING = frozenset({Verdict.WRONG_LIMIT, Verdict.DIVERGED})  # off the truth, which a finer run may refute
BLOWN_UP = frozenset({"non-finite", "reset"})


@dataclass(frozen=True)
class Point:
    """One run of a method, as far as a verdict asks."""

    setting: str  # as a reader would type it: step=0.001
    knob: float  # step (s) or relative tolerance
    status: str
    message: str = ""
    error: float | None = None  # from the truth, over the scene's scales; None without one
    gap: float | None = None  # from the finest run of the next coarser level, by the same measure
    refines: bool = True  # takes more steps than the coarser runs; else it is of their level
    rounding: float = 0.0  # what rounding may have left of the error

    @property
    def ok(self) -> bool:
        return self.status == "success"


class Control(NamedTuple):
    """Another engine's method of the same order, at the finest setting."""

    by: str
    error: float  # from the truth, over the scene's scales


def judge(
    points: Sequence[Point], order: float | None = None, uncertainty: float = 0.0, why_no_truth: str = "",
    control: Control | None = None, appeal: Point | None = None,
) -> tuple[Verdict, str]:  # fmt: skip
    """Return the verdict and its sentence. Points go from coarse to fine; `order` is that of the error in the knob."""
    good = [point for point in points if point.ok]
    if not good:
        return _without_success(points)
    if good[-1].error is None:
        return _without_truth(good, order, why_no_truth)
    verdict, reason = _by_error(good, order or 1.0, uncertainty)
    if verdict is Verdict.DIVERGED and control is not None and _is_as_far(levels(good)[-1], control):
        told = f"{reason}, where {control.by} is {control.error:.1e} off"
        verdict, reason = Verdict.NOT_SHOWN, f"{told}: too coarse for a motion that amplifies errors"
    if verdict in WRONG and above_rounding(good) != good:
        verdict, reason = _beside_rounding(good, order or 1.0, uncertainty)
    if verdict in STAYING and appeal is not None and _is_granted(levels(good)[-1], appeal):
        verdict, reason = Verdict.NOT_SHOWN, _granted(levels(good)[-1], appeal)
    return _with_failures(points, good, verdict, reason)


def _is_as_far(finest: Point, control: Control) -> bool:
    """Whether both are lost, the one about as far as the other: what blows up is farther than any motion goes."""
    error = finest.error or 0.0
    return min(error, control.error) > RESOLVED and error <= control.error / RESOLVED


def _is_granted(finest: Point, appeal: Point) -> bool:
    """Whether a plainly finer run shows that the error still falls."""
    return appeal.ok and appeal.error is not None and appeal.error <= STALLED * (finest.error or 0.0)


def _granted(finest: Point, appeal: Point) -> str:
    here = f"still {finest.error:.1e} off at {finest.setting}, but {appeal.error:.1e} at {appeal.setting}"
    return f"{here}: it approaches, at more work than is asked of all"


def speaking(points: Sequence[Point]) -> int:
    """Return the index of the run that speaks for a method: the finest in agreement, else the finest; -1 for none."""
    good = [k for k, point in enumerate(points) if point.ok]
    agreeing = [k for k in good if points[k].error is not None and points[k].error <= AGREEMENT]  # type: ignore[operator]
    return (agreeing or good or [-1])[-1]


def levels(good: Sequence[Point]) -> list[Point]:
    """Return one run a level, coarse to fine: the one with the largest error, the finest where none is known."""
    found: list[Point] = []
    for point in good:
        if point.refines or not found:
            found.append(point)
        elif point.error is None or point.error >= (found[-1].error or 0.0):
            found[-1] = point
    return found


def above_rounding(good: Sequence[Point]) -> list[Point]:
    """Return the runs up to the finest whose error is larger than what rounding may have left of it."""
    told = [k for k, point in enumerate(good) if point.error is not None and point.error > point.rounding]
    return list(good[: told[-1] + 1]) if told else []


def limit_distance(good: Sequence[Point], order: float) -> float | None:
    """Return how far the finest run is from the method's own limit, from the gaps of the last three; None if untold.

    With e = C s^p the gap between settings s2 > s3 is C (s2^p - s3^p), so that C s3^p = gap / ((s2/s3)^p - 1). p is the
    documented order, or the one that the two gaps show where that is less.
    """
    if len(good) < 3 or good[-1].gap is None or good[-2].gap is None or not good[-2].gap > 0.0:
        return None
    if good[-1].gap > SHRINKING * good[-2].gap:
        return None
    if good[-1].gap == 0.0:
        return 0.0
    coarse, middle, fine = (point.knob for point in good[-3:])
    shown = shown_order(coarse / middle, middle / fine, good[-2].gap / good[-1].gap)
    return None if shown is None else good[-1].gap / ((middle / fine) ** min(order, shown) - 1.0)


def shown_order(first: float, second: float, shrinkage: float) -> float | None:
    """Return the order p at which gaps shrink by `shrinkage` where settings do by factors `first`, then `second`.

    (first^p - 1) / (1 - second^-p) = shrinkage; None where no order is positive.
    """

    def excess(p: float) -> float:
        return math.expm1(p * math.log(first)) / -math.expm1(-p * math.log(second)) - shrinkage

    low, high = 1e-6, MOST_ORDER
    if excess(low) >= 0.0:
        return None
    return high if excess(high) <= 0.0 else float(root_scalar(excess, bracket=(low, high)).root)


def _by_error(good: Sequence[Point], order: float, uncertainty: float) -> tuple[Verdict, str]:
    errors = [point.error for point in good if point.error is not None]
    last, finest = good[-1], errors[-1]
    tail = len(errors) - 1 - max((k for k, error in enumerate(errors) if error > AGREEMENT), default=-1)
    if tail:
        if uncertainty > AGREEMENT / MARGIN:
            return Verdict.BELOW_TRUTH, f"{finest:.1e} at {last.setting}, and the truth is known to {uncertainty:.1e}"
        if tail >= 2 or (len(errors) >= 2 and _slope(good[-2], last) >= 0.5 * order):
            return Verdict.AGREES, f"{finest:.1e} from the truth at {last.setting}"
        return Verdict.NOT_SHOWN, f"only {last.setting} reaches {finest:.1e}: one run shows no convergence"
    refined = levels(good)
    last, finest = refined[-1], refined[-1].error or 0.0
    inside = [point for point in refined if point.error is not None and point.error <= AGREEMENT]
    if inside:
        best = inside[-1]
        return Verdict.LOST, f"{best.error:.1e} at {best.setting}, and lost again: {finest:.1e} at {last.setting}"
    if finest < MARGIN * uncertainty:
        return Verdict.BELOW_TRUTH, f"{finest:.1e} at {last.setting}, and the truth is known to {uncertainty:.1e}"
    if len(refined) == 1 and good[0].knob >= WIDE * good[-1].knob:
        span = f"{good[0].setting} to {good[-1].setting}"
        return Verdict.DIVERGED, f"the error does not fall: {finest:.1e}, with the same steps from {span}"
    distance = limit_distance(refined, order)
    if distance is not None and distance < SETTLED * finest:
        return Verdict.WRONG_LIMIT, f"within {distance:.1e} of its own limit, and the error stays at {finest:.1e}"
    return _by_trend(refined, order)


def _beside_rounding(good: Sequence[Point], order: float, uncertainty: float) -> tuple[Verdict, str]:
    """Judge the runs that rounding does not explain; the others are told of."""
    heard, next_one = above_rounding(good), good[len(above_rounding(good))]
    why = f"of {next_one.error:.1e} at {next_one.setting} rounding may have left {next_one.rounding:.1e}"
    if not heard:
        return Verdict.NOT_SHOWN, why
    verdict, reason = _by_error(heard, order, uncertainty)
    return verdict, f"{reason}; {why}"


def _by_trend(refined: Sequence[Point], order: float) -> tuple[Verdict, str]:
    last, finest = refined[-1], refined[-1].error or 0.0
    if len(refined) < 2:
        return Verdict.NOT_SHOWN, f"nothing finer than {last.setting} ran, {finest:.1e} off: that shows no convergence"
    slopes = [_slope(a, b) for a, b in pairwise(refined[-3:])]
    if min(slopes) >= 0.5 * order and finest <= RESOLVED:
        return Verdict.CONVERGING, f"{finest:.1e} at {last.setting}, falling with order {min(slopes):.2g}"
    if slopes[-1] > 0.0:
        pace = f"order {slopes[-1]:.2g}" + (f", less than half of {order:g}" if slopes[-1] < 0.5 * order else "")
        return Verdict.NOT_SHOWN, f"still {finest:.1e} off at {last.setting}, falling with {pace}"
    before = refined[-2].error or 0.0
    fell = _fell_from(refined)
    if fell is not None:
        told = f"its errors go up and down, and fell from {fell.error:.1e} at {fell.setting}"
        return Verdict.NOT_SHOWN, f"still {finest:.1e} off at {last.setting}: {told}"
    return Verdict.DIVERGED, f"the error does not fall: {before:.1e}, then {finest:.1e} at {last.setting}"


def _fell_from(refined: Sequence[Point]) -> Point | None:
    """Return the run PLAIN times as coarse as the finest from which the error fell, where the last rise is a bounce."""
    *_, before, last = (point.error or 0.0 for point in refined)
    plainly = next((point for point in reversed(refined) if point.knob >= PLAIN * refined[-1].knob), None)
    if plainly is None or last > BOUNCE * before or (plainly.error or 0.0) <= BOUNCE * last:
        return None
    return plainly


def _slope(coarse: Point, fine: Point) -> float:
    """Return the order at which the error fell between two runs; 0 where one of them has none to speak of."""
    if not coarse.error or not fine.error:
        return 0.0
    return math.log(coarse.error / fine.error) / math.log(coarse.knob / fine.knob)


def _without_success(points: Sequence[Point]) -> tuple[Verdict, str]:
    refused = [point for point in points if point.status in REFUSED]
    if len(refused) == len(points):
        return (Verdict(refused[-1].status), refused[-1].message) if refused else (Verdict.NOT_SHOWN, "no run was made")
    last = next(point for point in reversed(points) if point.status not in REFUSED)
    if last.status in (Verdict.TIMEOUT, Verdict.CRASHED, Verdict.OUT_OF_MEMORY):
        return Verdict(last.status), f"{last.setting}: {last.message}"
    verdict = Verdict.DIVERGED if last.status in BLOWN_UP else Verdict.FAILED
    return verdict, f"{last.setting}: {last.status}: {last.message}"


def _without_truth(good: Sequence[Point], order: float | None, why: str) -> tuple[Verdict, str]:
    distance = limit_distance(levels(good), order or 1.0)
    if distance is not None and distance <= RESOLVED:
        return Verdict.CONVERGING, f"to a limit of its own, {distance:.1e} away. No truth: {why}"
    return Verdict.NOT_SHOWN, f"no convergence shown, and no truth to compare with: {why}"


def _with_failures(
    points: Sequence[Point], good: Sequence[Point], verdict: Verdict, reason: str
) -> tuple[Verdict, str]:
    """A finer run that failed is told beside the verdict; where nothing else was shown, it is the verdict."""
    last = points[-1]
    if last.ok or last.status in REFUSED:
        return verdict, reason
    told = f"{reason}; {last.setting} ends with {last.status}: {last.message}"
    if verdict is not Verdict.NOT_SHOWN or last.knob > good[-1].knob:
        return verdict, told
    return (Verdict.DIVERGED if last.status in BLOWN_UP else Verdict.FAILED), told
