"""The words a cell may say, what they mean, and how loudly the page says them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Verdict:
    """A verdict's tone (good | fair | bad | plain) and meaning in plain words."""

    tone: str
    meaning: str


VERDICTS = {
    "agrees": Verdict("good", "reaches the truth within the tolerance asked"),
    "below-truth": Verdict("good", "too close for the truth to judge: it is not known 30 times better than this"),
    "converging": Verdict("fair", "approaches the truth as the step shrinks, but is not there yet"),
    "wrong-limit": Verdict("bad", "converges, but to another answer: a smaller step does not help"),
    "diverged": Verdict("bad", "does not approach the truth"),
    "failed": Verdict("bad", "stopped, or returned something it cannot vouch for"),
    "crashed": Verdict("bad", "the engine's process died"),
    "timeout": Verdict("bad", "did not finish in the time allowed"),
    "cannot": Verdict("plain", "cannot model this scene, and says why"),
    "engine-missing": Verdict("plain", "is not installed here"),
}
UNKNOWN = Verdict("plain", "a verdict this page does not know")


def verdict(word: str) -> Verdict:
    """Return what is known of a verdict word."""
    return VERDICTS.get(word, UNKNOWN)
