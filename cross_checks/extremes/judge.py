"""The verdict on one run: what the engine said, against what is true.

The rule, the same for every engine, ours included:

- survived: it reported success and the error is at most the extreme's `good`;
- stopped: it refused or stopped and said why; so did our own checks for a run that never came back;
- degraded: it reported success, and the error is above `good` but no lie (see below), or its own estimate of the
  error says that it is another motion, off by more than `wrong`;
- silently-wrong: it reported success, or said nothing, and yet gave NaN, restarted its clock, accepted what
  has no right answer, or is off by more than the extreme's `wrong`, whatever its tolerance. Errors are shares
  of the motion's size: one of 1 is as large as the motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

from cross_checks.extremes.extreme import Case, Extreme
from cross_checks.records.record import CANNOT
from mbs_ref.trajectory import Status, Trajectory


class Fate(StrEnum):
    """What became of a run."""

    SURVIVED = "survived"
    DEGRADED = "degraded"
    STOPPED = "stopped"
    SILENTLY_WRONG = "silently-wrong"
    CANNOT = "cannot"


@dataclass(frozen=True)
class Point:
    """One run along the axis, judged."""

    value: float  # place on the axis
    fate: Fate
    handled: bool  # right, or refused where refusing is right
    said_fine: bool  # the engine itself reported no trouble
    error: float | None  # of the motion's size; None where there is nothing to measure
    status: str  # what our checks made of it
    reason: str  # one sentence
    seconds: float = 0.0  # wall time, build and judgement included

    @property
    def caught(self) -> bool:
        """Whether the engine said nothing and our checks found the failure."""
        return self.said_fine and self.fate is Fate.SILENTLY_WRONG and self.status != Status.SUCCESS


def judge(extreme: Extreme, case: Case, value: float, run: Trajectory | tuple[str, str]) -> Point:
    """Return the verdict on a trajectory, or on a status and a sentence where there is none."""
    if not isinstance(run, Trajectory):
        status, message = run
        return _stopped(case, value, status, message)
    if run.unreported or run.status is Status.RESET:
        reason = f"it went on as if all were well: {run.message}"
        return Point(value, Fate.SILENTLY_WRONG, False, True, None, str(run.status), reason)
    if not run.ok:
        return _stopped(case, value, str(run.status), run.message)
    if case.must_stop:
        return _accepted(extreme, value, run)
    return _by_error(extreme, value, case.measure(case.scene, run), run)


def lost(value: float, status: str, message: str) -> Point:
    """Return the verdict on a run whose process was lost: timeout, crashed or out-of-memory."""
    return Point(value, Fate.STOPPED, False, False, None, status, message)


def _stopped(case: Case, value: float, status: str, message: str) -> Point:
    # a setting that is refused at this place of the axis is a stop with a reason
    right = case.must_stop or case.may_stop
    return Point(value, Fate.STOPPED, right, False, None, "refused" if status == CANNOT else status, message)


def _accepted(extreme: Extreme, value: float, run: Trajectory) -> Point:
    """Judge a success where there is no right answer: to say that it is another motion is as good as a refusal."""
    said = _says_wrong(extreme, run)
    reason = f"it says itself that {said}" if said else "it accepted what has no right answer"
    fate = Fate.DEGRADED if said else Fate.SILENTLY_WRONG
    return Point(value, fate, bool(said), not said, None, str(run.status), reason)


def _says_wrong(extreme: Extreme, run: Trajectory) -> str:
    """Return the run's own words that it is off by more than `wrong` of the motion's size, or nothing."""
    estimate = run.estimate
    if estimate is None or estimate.poses[-1] <= extreme.wrong * estimate.size:
        return ""
    return estimate.remark()


def _by_error(extreme: Extreme, value: float, error: float, run: Trajectory) -> Point:
    if not math.isfinite(error) or error > extreme.wrong:
        shown = f"{error:.2g} of the motion's size" if math.isfinite(error) else "beyond all measure"
        reason = f"success, but the error is {shown}; more than {extreme.wrong:.2g} is another motion"
        said = _says_wrong(extreme, run)
        if said:
            return Point(value, Fate.DEGRADED, False, False, _finite(error), "success", f"{reason}; it says so: {said}")
        return Point(value, Fate.SILENTLY_WRONG, False, True, _finite(error), "success", reason)
    fate = Fate.SURVIVED if error <= extreme.good else Fate.DEGRADED
    reason = f"error {error:.2g} of the motion's size"
    return Point(value, fate, fate is Fate.SURVIVED, True, error, "success", reason)


def _finite(error: float) -> float | None:
    return error if math.isfinite(error) else None
