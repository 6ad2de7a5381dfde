"""A synthetic method as the search sees it, and the classifier that calibrates the convergence model.

python -m tests.cross_checks.convergence.searched calibration --seeds 0 2000
"""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

from cross_checks.judge.bounds import AGREEMENT, TARGETS
from cross_checks.judge.convergence import FILE, calibration
from cross_checks.judge.search import Search
from cross_checks.judge.tried import FIRST_RTOL, typical_facts
from cross_checks.judge.verdict import Point
from tests.cross_checks.convergence.law import MOST_STEPS, OUTPUTS, SyntheticMethod, size
from tests.cross_checks.convergence.measure import Answer, evaluate, markdown, mistakes, report
from tests.cross_checks.convergence.synthetic import CALIBRATION, HELD_OUT

FAMILIES = {"calibration": CALIBRATION, "held-out": HELD_OUT}
FIRST_STEPS = 400  # of the first run with fixed steps


class Searched(Search):
    """One synthetic method; errors are relative to the scene."""

    why_no_truth, outputs, most_steps = "", OUTPUTS, MOST_STEPS

    def __init__(self, method: SyntheticMethod) -> None:
        super().__init__()
        self.method, self.kind, self.duration = method, method.kind, method.duration
        p = float(method.order)
        self.documented_order = p / (p + 1.0) if method.kind == "adaptive" else p if method.is_smooth else min(p, 1.0)
        self.local_order = method.embedded + 1
        self.expected = p / self.local_order if method.kind == "adaptive" else self.documented_order
        self.coarsest, self.finest = method.coarsest, method.finest
        self.states: dict[float, Any] = {}

    def typed(self, knob: float) -> float:
        """Return a tolerance of two digits, or a step that divides the output interval."""
        if self.kind == "adaptive":
            return float(f"{max(1e-14, knob):.1e}")
        interval = self.duration / OUTPUTS
        return interval / math.ceil(interval / knob * (1.0 - 1e-9))

    def run(self, knob: float) -> Point:
        outcome = self.method.run(knob)
        self.states[knob] = outcome.state
        error = None if outcome.state is None else size(outcome.state)
        message = "step" if outcome.status == "cannot" else outcome.status
        rounding = self.method.roundoff * outcome.steps * self.method.amplification
        return Point(f"{knob:g}", knob, outcome.status, message, error, outcome.steps, rounding)

    def gap(self, first: float, second: float) -> float:
        return size(self.states[first] - self.states[second])

    def seconds(self, steps: float) -> None:
        return None

    def facts(self) -> dict:
        amplified = math.log10(self.method.amplification)
        facts = typical_facts(self.kind, self.method.order, self.expected, self.duration, self.method.uncertainty)
        return facts | {"typical": facts["typical"] + amplified}

    def reference_error(self, knob: float) -> None:
        return None


def classify(method: SyntheticMethod, seed: int) -> Answer:
    """Return the verdict on a method, its odds and the number of runs."""
    search = Searched(method)
    if search.begin(FIRST_RTOL if method.kind == "adaptive" else method.duration / FIRST_STEPS):
        search.reach(TARGETS)
    verdict, shown = search.settle().verdict, search.shown()
    if shown is None:
        return str(verdict), {}, len(search.points)
    bar = max(AGREEMENT, 10.0 * method.uncertainty)
    odds = {"wrong_limit": shown.odds_of_limit(bar), "none": shown.odds_of_stall(bar)}
    return str(verdict), odds, len(search.points)


def main() -> None:
    """Print the figures of a family and its worst twenty verdicts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("family", choices=FAMILIES, nargs="?")
    parser.add_argument("--seeds", type=int, nargs=2, default=(0, 5000), metavar=("FIRST", "LAST"))
    parser.add_argument("--write", action="store_true", help="keep the figures for the method page of the report")
    given = parser.parse_args()
    found = evaluate(classify, FAMILIES[given.family], range(*given.seeds))
    figures = report(found)
    print(markdown(figures))
    for one in mistakes(found)[:20]:
        m = one.method
        what = f"{m.label}, {m.category}, {m.kind} {m.order}, limit {m.limit_distance:.1e}"
        print(f"{what}: {one.verdict}, {one.runs} runs")
    if given.write:
        kept = calibration() if FILE.exists() else {}
        FILE.write_text(json.dumps(kept | {given.family: figures}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
