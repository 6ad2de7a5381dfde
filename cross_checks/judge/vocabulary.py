"""The words of a comparison, defined once: verdicts with a code and a meaning, and what became of a target.

Pages, JSON, commands and documents refer to these definitions. Codes are stable: others may cite them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal, NamedTuple

from cross_checks.records.record import Record

AGREEMENT = 1e-6  # of the scene: an error at or below this is agreement


class Verdict(StrEnum):
    """What the runs of one method on one scene show."""

    AGREES = "agrees"
    BELOW_TRUTH = "below-truth"
    CONVERGING = "converging"
    NOT_SHOWN = "not-shown"
    WRONG_LIMIT = "wrong-limit"
    LOST = "lost"
    DIVERGED = "diverged"
    FAILED = "failed"
    CRASHED = "crashed"
    TIMEOUT = "timeout"
    OUT_OF_MEMORY = "out-of-memory"
    CANNOT = "cannot"
    ENGINE_MISSING = "engine-missing"


class Meaning(NamedTuple):
    """A verdict's stable code, its tone on a page and its meaning in one sentence."""

    code: str
    tone: Literal["good", "fair", "bad", "plain"]
    sentence: str


MEANINGS = {
    Verdict.AGREES: Meaning("MBS.V01", "good", "the error falls to 1e-6 of the scene or less, and stays there"),
    Verdict.BELOW_TRUTH: Meaning("MBS.V02", "good", "the error is too small to be resolved by this scene's truth"),
    Verdict.CONVERGING: Meaning("MBS.V03", "fair", "the error falls at the expected order, and is above 1e-6 still"),
    Verdict.NOT_SHOWN: Meaning("MBS.V04", "fair", "the runs within the work limit decide nothing"),
    Verdict.WRONG_LIMIT: Meaning("MBS.V05", "bad", "the method converges to another motion than the truth"),
    Verdict.LOST: Meaning("MBS.V06", "bad", "the error was 1e-6 or less, and grew again at finer settings"),
    Verdict.DIVERGED: Meaning("MBS.V07", "bad", "the error does not fall with finer settings"),
    Verdict.FAILED: Meaning("MBS.V08", "bad", "the engine stopped with an error before the end"),
    Verdict.CRASHED: Meaning("MBS.V09", "bad", "the engine's process died"),
    Verdict.TIMEOUT: Meaning("MBS.V10", "bad", "a run exceeded its time limit"),
    Verdict.OUT_OF_MEMORY: Meaning("MBS.V11", "bad", "a run exceeded its memory limit"),
    Verdict.CANNOT: Meaning("MBS.V12", "plain", "the engine cannot model this scene, with the reason"),
    Verdict.ENGINE_MISSING: Meaning("MBS.V13", "plain", "the engine is not installed"),
}
WRONG = frozenset(verdict for verdict, meaning in MEANINGS.items() if meaning.tone == "bad")
REFUSED = frozenset({Verdict.CANNOT, Verdict.ENGINE_MISSING})
SILENT = frozenset({Verdict.WRONG_LIMIT, Verdict.LOST, Verdict.DIVERGED})  # the runs behind them report success

Answer = Literal["reached", "not-reached", "not-tried", "cannot", "unjudged"]


@dataclass(frozen=True)
class TargetResult:
    """What became of one target error."""

    target: float  # over the scene's scales
    answer: Answer
    record: Record | None = None  # of the cheapest run that reached it
    reason: str = ""
