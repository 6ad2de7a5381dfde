"""The fate of one run, from what the engine reports and how likely its error is small: one rule for every engine.

- survived: it reports success, and its error is likely within the coarsest target of a comparison;
- degraded: it reports success with a larger error, and the motion is resolved or its own error estimate states that
  it is not;
- stopped: it refuses or stops with a reason, or its process is lost;
- silently-wrong: it reports success, or nothing, yet gives NaN, restarts its clock, accepts what has no right answer,
  or does not resolve the motion.

The odds of an error come from the posterior of convergence of this one run: its setting, what is typical there, the
truth's uncertainty and rounding. Errors are in units of the motion's size. A cell of the matrix is an engine's method
along one axis, stored as a line of JSON.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import takewhile
from pathlib import Path

import numpy as np

from cross_checks.engine import Method
from cross_checks.extremes import Case, Measured
from cross_checks.judge.bounds import EVEN, RESOLVED, TARGETS
from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import posterior
from cross_checks.judge.convergence.prediction import odds_below
from cross_checks.judge.tried import facts_of
from cross_checks.records import lines
from cross_checks.records.record import CANNOT
from mbs_ref import Status, Trajectory


class Fate(StrEnum):
    """What became of a run, worst first."""

    SILENTLY_WRONG = "silently-wrong"
    DEGRADED = "degraded"
    STOPPED = "stopped"
    SURVIVED = "survived"
    CANNOT = "cannot"


@dataclass(frozen=True)
class Point:
    """One run along the axis with its fate."""

    value: float  # place on the axis
    fate: Fate
    odds: float  # that it is right, or refused where refusing is right
    is_silent: bool  # the engine itself reports no trouble
    error: float | None  # of the motion's size; None where there is nothing to measure
    status: str  # after the checks of every run
    reason: str  # one sentence
    seconds: float = 0.0  # wall time with build and judgement

    @property
    def handled(self) -> bool:
        """Whether it is more likely right than not, or refused where refusing is right."""
        return self.odds >= EVEN

    @property
    def caught(self) -> bool:
        """Whether the engine reports nothing and the checks of every run detect the failure."""
        return self.is_silent and self.fate is Fate.SILENTLY_WRONG and self.status != Status.SUCCESS


def judge(case: Case, method: Method, value: float, run: Trajectory | tuple[str, str]) -> Point:
    """Return the fate of a trajectory, or of a status and a sentence where there is none."""
    status, message = (str(run.status), run.message) if isinstance(run, Trajectory) else run
    if isinstance(run, Trajectory) and (run.unreported or run.status is Status.RESET):
        return Point(value, Fate.SILENTLY_WRONG, 0.0, True, None, status, f"it went on without a word: {message}")
    if not isinstance(run, Trajectory) or not run.ok:
        # a setting that is refused at this place of the axis is a stop with a reason
        status = "refused" if status == CANNOT else status
        return Point(value, Fate.STOPPED, float(case.must_stop or case.may_stop), False, None, status, message)
    estimate = run.estimate  # its own words, if it does not resolve the motion
    states = estimate.remark() if estimate is not None and estimate.poses[-1] > RESOLVED * estimate.size else ""
    if case.must_stop:  # to state that it is another motion is as good as a refusal
        fate = Fate.DEGRADED if states else Fate.SILENTLY_WRONG
        reason = f"it states itself that {states}" if states else "it accepted what has no right answer"
        return Point(value, fate, float(bool(states)), not states, None, status, reason)
    measured = case.measure(case.scene, run)
    within, resolved = odds_within(case, method, run, measured, (TARGETS[0], RESOLVED))
    error = measured.error if math.isfinite(measured.error) else None
    reason = f"error {measured.error:.2g} of the motion's size"
    if resolved < EVEN:
        reason = f"success, but another motion: {reason}" + (f"; it states so: {states}" if states else "")
        return Point(value, Fate.DEGRADED if states else Fate.SILENTLY_WRONG, within, not states, error, status, reason)
    return Point(value, Fate.SURVIVED if within >= EVEN else Fate.DEGRADED, within, True, error, status, reason)


def odds_within(
    case: Case, method: Method, run: Trajectory, measured: Measured, bars: tuple[float, ...]
) -> tuple[float, ...]:
    """Return the odds that the run's error is at most each of the bars."""
    if not math.isfinite(measured.error):
        return (0.0,) * len(bars)
    facts = facts_of(method, case.scene, float(case.times[-1]), measured.uncertainty)
    knob = (case.step if method.kind == "fixed" else case.rtol) or math.nan
    one = (knob, measured.error, run.steps, method.rounding(run.steps))
    shown = posterior(Ladder.of([one], np.zeros((1, 1)), **facts))
    return tuple(float(odds_below(shown, np.array([knob]), bar)[0]) for bar in bars)


@dataclass(frozen=True)
class Cell:
    """What became of one method of one engine along one axis."""

    extreme: str
    family: str
    engine: str
    method: str
    full: bool  # the whole axis searched finely, or a quick look at its listed values
    fate: Fate  # the worst that happened
    last: float | None  # most extreme value up to which all went right
    points: tuple[Point, ...]
    reason: str = ""  # why it cannot, or the first of the worst failures
    made: str = ""  # date and revision of the runs

    @property
    def key(self) -> tuple[str, str, str, bool]:
        return self.extreme, self.engine, self.method, self.full

    @property
    def first_failure(self) -> str:
        """What comes beyond `last`; empty where all went right."""
        return next((point.reason for point in self.points if not point.handled), "")


def made_of(extreme: str, family: str, engine: str, method: str, full: bool, points: Iterable[Point]) -> Cell:
    """Return the cell of the points, mild first."""
    every = tuple(points)
    handled = tuple(takewhile(lambda point: point.handled, every))
    failures = [point for point in every if not point.handled]
    reason = next((point.reason for point in failures if point.fate is _worst(failures)), "")
    last = handled[-1].value if handled else None
    return Cell(extreme, family, engine, method, full, _worst(every), last, every, reason)


def _worst(points: Sequence[Point]) -> Fate:
    return next(fate for fate in Fate if any(point.fate is fate for point in points))


def read(path: Path) -> tuple[list[Cell], list[str]]:
    """Return the cells of a file, the last of each key, and a sentence for every line that is none."""
    cells, problems = lines.read(path, Cell)
    return list({cell.key: cell for cell in cells}.values()), problems
