"""The regression verdict on trees whose answer is known: unchanged copies, and copies with a slowed kernel."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from benchmarks.trees.regression import Finding, regressions
from benchmarks.trees.slowed import HERE, calibrate, case_named, copy_tree
from cross_checks.prices.timing import Pace

CASE = case_named("pendulum_chain links=10 mbs_ref dop853")
TIMES = 10
SHARE = 0.15  # of the loop time


def verdicts(folder: Path) -> list[Finding]:
    """Compare this tree with the folder as `mbs-ref compare` does, each time with processes and an order of its own."""
    return [finding for seed in range(TIMES) for finding in regressions(HERE, folder, [CASE], seed=seed)]


def told(benchmark, findings: list[Finding], **facts: float) -> Counter[str]:
    counts = Counter(str(finding.verdict) for finding in findings)
    benchmark.extra_info |= {"verdicts": dict(counts), **facts}
    for finding in findings:
        print(f"{finding.verdict}: {finding.sentence}")
    return counts


@pytest.fixture
def copy(tmp_path) -> Path:
    return copy_tree(tmp_path / "copy")


def test_an_unchanged_copy_is_called_same(benchmark, copy):
    findings: list[Finding] = []
    benchmark.pedantic(lambda: findings.extend(verdicts(copy)), rounds=1)
    assert told(benchmark, findings)[Pace.SAME] == TIMES


def test_a_slowed_kernel_is_called_slower(benchmark, copy):
    turns, share = calibrate(copy, CASE, SHARE)
    print(f"slowed by {share:.1%} with {turns} square roots a right-hand side")
    findings: list[Finding] = []
    benchmark.pedantic(lambda: findings.extend(verdicts(copy)), rounds=1)
    assert told(benchmark, findings, share=share)[Pace.SLOWER] == TIMES
