"""Measure a classifier on synthetic methods: false accusations, missed wrong limits, calibration of its odds.

print(markdown(report(evaluate(classify, HELD_OUT, range(4000)))))
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from cross_checks.judge.vocabulary import WRONG, Verdict
from tests.cross_checks.convergence.law import Label, Outcome, SyntheticMethod, size
from tests.cross_checks.convergence.synthetic import BAR, Category, draw

PASSING = frozenset({Verdict.AGREES, Verdict.BELOW_TRUTH, Verdict.CONVERGING})
BINS = (0.0, 0.01, 0.1, 0.3, 0.7, 0.9, 0.99, 1.0)  # of stated odds
SETTLED = 0.1  # of a limit's distance: a run this near to it is settled
ENOUGH = 10.0  # expected events in a bin whose odds are compared with what came true
ROUNDING = 30.0  # times roundoff x steps x amplification: a smaller error may be that of rounding
MISTAKES: list[tuple[Label, str]] = [  # the worst first
    ("correct", "called wrong"), ("wrong-limit", "passed"), ("never", "passed"),
    ("correct", "open"), ("wrong-limit", "open"), ("never", "open"),
]  # fmt: skip

type Answer = tuple[str, Mapping[str, float], int]  # verdict, odds of wrong_limit and none, number of runs
type Classifier = Callable[[SyntheticMethod, int], Answer]


@dataclass(frozen=True)
class Judged:
    """A method and what the classifier states of it."""

    method: SyntheticMethod
    verdict: str
    runs: int
    finest: Outcome | None  # of the runs that succeeded
    odds: Mapping[str, float] = field(default_factory=dict)
    reason: str = ""

    @property
    def outcome(self) -> str:
        """Return whether the verdict passes the method, calls it wrong, or leaves it open."""
        return "passed" if self.verdict in PASSING else "called wrong" if self.verdict in WRONG else "open"

    @property
    def is_shown(self) -> bool:
        """Whether the finest run shows a fault: a limit within SETTLED of its distance, or no convergence to BAR."""
        if self.finest is None or self.finest.state is None:
            return self.method.label == "never"
        if self.method.label == "never":
            return size(self.finest.state) > BAR
        return size(self.finest.state - self.method.limit) <= SETTLED * self.method.limit_distance

    @property
    def is_rounded(self) -> bool:
        """Whether the finest run's error may be that of rounding."""
        if self.finest is None or self.finest.state is None:
            return False
        rounding = self.method.roundoff * self.finest.steps * self.method.amplification
        return size(self.finest.state) <= ROUNDING * rounding


def evaluate(classify: Classifier, family: tuple[Category, ...], seeds: Iterable[int]) -> list[Judged]:
    """Return what a classifier states of the methods of these seeds, each with the finest run that it requested."""
    return [_evaluated(classify, draw(seed, family), seed) for seed in seeds]


def _evaluated(classify: Classifier, method: SyntheticMethod, seed: int) -> Judged:
    requested: dict[float, Outcome] = {}

    def law(setting: float) -> Outcome:
        return requested.setdefault(setting, method.run(setting))

    verdict, odds, runs = classify(replace(method, law=law), seed)
    finest = next((requested[s] for s in sorted(requested) if requested[s].state is not None), None)
    return Judged(method, verdict, runs, finest, odds)


def report(judged: Sequence[Judged]) -> dict[str, Any]:
    """Return every figure: counts by label, mistakes by category, reliability of the odds of a wrong limit."""
    by_label = {label: [j for j in judged if j.method.label == label] for label in ("correct", "wrong-limit", "never")}
    groups = by_label | {f"{label}, shown": [j for j in by_label[label] if j.is_shown] for label in list(by_label)[1:]}
    return {
        "methods": len(judged),
        "share of wrong limits": len(groups["wrong-limit"]) / len(judged),
        "runs": sum(j.runs for j in judged) / len(judged),
        "groups": {name: {"methods": len(group)} | Counter(j.outcome for j in group) for name, group in groups.items()},
        "called wrong on one run": sum(j.outcome == "called wrong" and j.runs < 2 for j in groups["correct"]),
        "mistakes": Counter(f"{j.method.label}, {j.method.category}: {j.outcome}" for j in mistakes(judged)),
        "odds of a wrong limit": reliability([j for j in judged if not j.is_rounded]),
        "odds of a wrong limit where rounding rules": reliability([j for j in judged if j.is_rounded]),
    }


def mistakes(judged: Sequence[Judged]) -> list[Judged]:
    """Return the methods with a mistaken verdict, the worst first; faults only that the finest run shows."""
    ranks = {mistake: rank for rank, mistake in enumerate(MISTAKES)}
    mistaken = [
        j for j in judged if (j.method.label, j.outcome) in ranks and (j.is_shown or j.method.label == "correct")
    ]
    return sorted(mistaken, key=lambda j: ranks[j.method.label, j.outcome])


def reliability(
    judged: Sequence[Judged], key: str = "wrong_limit", label: Label = "wrong-limit"
) -> list[dict[str, Any]]:
    """Return for each bin of stated odds: count, mean stated, share that came true, and whether they agree."""
    known = [(j.odds[key], j.method.label == label) for j in judged if key in j.odds]
    bins = [
        (low, high, [k for k in known if low <= k[0] < high or k[0] == high == 1.0]) for low, high in pairwise(BINS)
    ]
    return [{"from": low, "to": high, "count": len(inside)} | _compared(inside) for low, high, inside in bins]


def _compared(inside: Sequence[tuple[float, bool]]) -> dict[str, Any]:
    """Return whether events, and their absence, came within a factor 2 where ENOUGH are expected; None elsewhere."""
    if not inside:
        return {"stated": None, "came true": None, "within 2": None}
    stated, true = np.array(inside).T
    pairs = [(np.sum(stated), np.sum(true)), (np.sum(1.0 - stated), np.sum(1.0 - true))]
    within = [bool(0.5 * expected <= came <= 2.0 * expected) for expected, came in pairs if expected >= ENOUGH]
    return {
        "stated": float(np.mean(stated)), "came true": float(np.mean(true)), "within 2": all(within) if within else None
    }  # fmt: skip


def markdown(figures: Mapping[str, Any]) -> str:
    """Return the groups and the reliability diagrams as Markdown tables."""
    lines = [
        f"{figures['methods']} methods, {figures['share of wrong limits']:.0%} with a wrong limit, "
        f"{figures['runs']:.1f} runs each; {figures['called wrong on one run']} correct ones called wrong on one run.",
        "", "| methods | | passed | called wrong | open |", "|---|---|---|---|---|",
    ]  # fmt: skip
    for name, row in figures["groups"].items():
        counts = [(row.get(outcome, 0), row["methods"]) for outcome in ("passed", "called wrong", "open")]
        cells = " | ".join(f"{n} ({n / max(1, of):.2%})" for n, of in counts)
        lines.append(f"| {name} | {row['methods']} | {cells} |")
    for title in ("odds of a wrong limit", "odds of a wrong limit where rounding rules"):
        rows = [row for row in figures[title] if row["count"]]
        if rows:
            lines += [
                "",
                f"| {title} | methods | mean stated | came true | within a factor 2 |",
                "|---|---|---|---|---|",
            ]
        for row in rows:
            word = {None: "too few", True: "yes", False: "no"}[row["within 2"]]
            shares = f"{row['stated']:.4f} | {row['came true']:.4f}"
            lines.append(f"| {row['from']:g} to {row['to']:g} | {row['count']} | {shares} | {word} |")
    return "\n".join(lines) + "\n"
