"""The verdict on a method from a ladder of ever finer runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from cross_checks.records.record import MARGIN

AGREEMENT = 1e-6  # m: closer to the truth than this is agreement; in the sky, of the scene's unit length
SETTLED = 0.1  # of the error: refinements that differ by less no longer approach the truth
SETTLING = 0.3  # of the error: the same, where the error does not shrink at all
PROGRESS = 0.7  # of the error before: less than this is progress


class Verdict(StrEnum):
    AGREES = "agrees"
    CONVERGING = "converging"
    WRONG_LIMIT = "wrong-limit"
    DIVERGED = "diverged"
    CANNOT = "cannot"
    FAILED = "failed"
    BELOW_TRUTH = "below-truth"
    ENGINE_MISSING = "engine-missing"
    TIMEOUT = "timeout"
    CRASHED = "crashed"
    OUT_OF_MEMORY = "out-of-memory"


@dataclass(frozen=True)
class Rung:
    """One run of the ladder."""

    setting: str  # as a reader would type it: step=0.001
    status: str
    message: str
    error: float | None = None  # m, from the truth; None without one
    difference: float | None = None  # m, from the run before; None for the first

    @property
    def ok(self) -> bool:
        return self.status == "success"


def judge(
    rungs: Sequence[Rung], uncertainty: float = 0.0, why_no_truth: str = "", agreement: float = AGREEMENT
) -> tuple[Verdict, str]:
    """Return the verdict and its sentence. Rungs go from coarse to fine; `uncertainty` (m) is the truth's.

    wrong-limit: the differences between refinements shrink well below the error, and the error stays.
    """
    refused = next((r for r in rungs if r.status in (Verdict.CANNOT, Verdict.ENGINE_MISSING)), None)
    good = [r for r in rungs if r.ok]
    if not good:
        if refused is not None:
            return Verdict(refused.status), refused.message
        return _stopped(rungs[-1])
    if good[-1].error is None:
        return _without_truth(good, why_no_truth)
    kept = good[: telling(good, agreement) + 1]
    verdict, reason = _by_error(kept, uncertainty, agreement)
    if len(kept) < len(good):
        reason += f", and lost again: {good[-1].error:.1e} m at {good[-1].setting}"
    return _with_failures(rungs, verdict, reason)


def telling(rungs: Sequence[Rung], agreement: float = AGREEMENT) -> int:
    """Return the index of the run that speaks for the ladder, -1 where none succeeded.

    The finest that succeeded; or the finest in agreement, where at least two agree and finer ones do not.
    """
    agree = [k for k, r in enumerate(rungs) if r.ok and r.error is not None and r.error <= agreement]
    finest = max((k for k, r in enumerate(rungs) if r.ok), default=-1)
    return agree[-1] if len(agree) > 1 else finest


def is_telling(good: Sequence[Rung]) -> bool:
    """Whether the last runs show a trend: errors that shrink, or have settled. Otherwise a finer run may yet."""
    errors = [r.error for r in good if r.error is not None]
    return len(errors) < 2 or errors[-1] < PROGRESS * errors[-2] or _is_settled(good)


def _stopped(last: Rung) -> tuple[Verdict, str]:
    if last.status in (Verdict.TIMEOUT, Verdict.CRASHED, Verdict.OUT_OF_MEMORY):
        return Verdict(last.status), f"{last.setting}: {last.message}"
    blown = last.status in ("non-finite", "reset")
    return (Verdict.DIVERGED if blown else Verdict.FAILED), f"{last.setting}: {last.status}: {last.message}"


def _by_error(good: Sequence[Rung], uncertainty: float, agreement: float) -> tuple[Verdict, str]:
    errors = [r.error for r in good if r.error is not None]
    finest = errors[-1]
    if finest <= agreement and uncertainty <= agreement / MARGIN:
        return Verdict.AGREES, f"{finest:.1e} m from the truth at {good[-1].setting}"
    if finest < MARGIN * uncertainty:
        known = f"the truth, known to {uncertainty:.1e} m, judges no error below {MARGIN * uncertainty:.1e} m"
        return Verdict.BELOW_TRUTH, f"{finest:.1e} m at {good[-1].setting}, and {known}"
    if _is_settled(good):
        return Verdict.WRONG_LIMIT, (
            f"refinements differ by {good[-1].difference:.1e} m and less, and the error stays at {finest:.1e} m"
        )
    if len(errors) > 1 and finest < PROGRESS * errors[-2]:
        return Verdict.CONVERGING, f"{finest:.1e} m at {good[-1].setting}, and still shrinking"
    if len(errors) == 1:
        return Verdict.FAILED, f"only {good[0].setting} ran, {finest:.1e} m off: one run shows no convergence"
    return Verdict.DIVERGED, f"the error does not shrink: {errors[-2]:.1e} m, then {finest:.1e} m at {good[-1].setting}"


def _is_settled(good: Sequence[Rung]) -> bool:
    """Whether the last runs agree with each other much better than with the truth, ever more so."""
    gaps = [r.difference for r in good[1:] if r.difference is not None]
    errors = [r.error for r in good if r.error is not None]
    if len(gaps) < 2:
        return False
    stays = errors[-1] > (1.0 - 2.0 * SETTLED) * errors[-2] and gaps[-1] < SETTLED * errors[-1]
    grows = errors[-1] >= errors[-2] and gaps[-1] < SETTLING * errors[-1]
    return (stays and gaps[-1] <= max(gaps[:-1])) or (grows and gaps[-1] < PROGRESS * gaps[-2])


def _without_truth(good: Sequence[Rung], why: str) -> tuple[Verdict, str]:
    gaps = [r.difference for r in good if r.difference is not None]
    if len(gaps) > 1 and gaps[-1] < gaps[-2]:
        return Verdict.CONVERGING, f"to itself: the last runs differ by {gaps[-1]:.1e} m. No truth: {why}"
    return Verdict.FAILED, f"no convergence shown, and no truth to compare with: {why}"


def _with_failures(rungs: Sequence[Rung], verdict: Verdict, reason: str) -> tuple[Verdict, str]:
    """A finer run that failed is told beside the best one's verdict, and spoils all but agreement."""
    last = rungs[-1]
    if last.ok:
        return verdict, reason
    told = f"{reason}; {last.setting} ends with {last.status}: {last.message}"
    kept = verdict in (Verdict.AGREES, Verdict.WRONG_LIMIT, Verdict.BELOW_TRUTH)
    return (verdict if kept else _stopped(last)[0]), told
