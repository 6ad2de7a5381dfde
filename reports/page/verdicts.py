"""The words a cell may say, what they mean, and how loudly the page says them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Verdict:
    """A verdict's tone (good | fair | bad | plain) and meaning in plain words."""

    tone: str
    meaning: str


VERDICTS = {
    "agrees": Verdict("good", "reaches the truth to 1e-6 of the scene, and finer settings stay there"),
    "below-truth": Verdict("good", "too close for the truth to judge: it is not known 30 times better than this"),
    "converging": Verdict("fair", "approaches the truth as the setting gets finer, and is not within 1e-6 yet"),
    "not-shown": Verdict("fair", "too few runs within the bound on work to show that it converges"),
    "wrong-limit": Verdict("bad", "converges, but to another answer: a finer setting does not help"),
    "lost": Verdict("bad", "was within 1e-6, and a finer setting lost it again"),
    "diverged": Verdict("bad", "does not approach the truth"),
    "failed": Verdict("bad", "stopped, or returned something it cannot vouch for"),
    "crashed": Verdict("bad", "the engine's process died"),
    "timeout": Verdict("bad", "one run did not come back"),
    "out-of-memory": Verdict("bad", "one run used all the memory allowed"),
    "cannot": Verdict("plain", "cannot model this scene, and says why"),
    "engine-missing": Verdict("plain", "is not installed here"),
}
SILENT = frozenset({"wrong-limit", "lost", "diverged"})  # the runs behind them report success
UNKNOWN = Verdict("plain", "a verdict this page does not know")


def verdict(word: str) -> Verdict:
    """Return what is known of a verdict word."""
    return VERDICTS.get(word, UNKNOWN)
