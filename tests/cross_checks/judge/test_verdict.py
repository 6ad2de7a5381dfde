"""Verdicts and observed orders on made-up error sequences."""

from __future__ import annotations

import pytest

from cross_checks.judge.verdict import Rung, Verdict, judge
from cross_checks.metrics.observed_order import observed_order


def ladder(errors, gaps, **last) -> list[Rung]:
    found = [Rung(f"step={k}", "success", "", e, g) for k, (e, g) in enumerate(zip(errors, [None, *gaps], strict=True))]
    return [*found, Rung("step=last", **last)] if last else found


@pytest.mark.parametrize(
    ("errors", "gaps", "uncertainty", "verdict"),
    [
        ([1e-2, 1e-4, 1e-7], [1e-2, 1e-4], 1e-14, Verdict.AGREES),
        ([1e-2, 1e-3, 1e-4], [9e-3, 9e-4], 1e-14, Verdict.CONVERGING),
        ([2.0, 2.0, 2.0], [1e-3, 1e-6], 1e-14, Verdict.WRONG_LIMIT),
        ([1.99, 2.02, 2.03], [3e-2, 1e-2], 1e-14, Verdict.WRONG_LIMIT),
        ([0.14, 0.17, 0.19], [0.06, 0.03], 1e-14, Verdict.WRONG_LIMIT),  # first order, towards another answer
        ([2.0, 2.0, 2.0], [1.0, 1.5], 1e-14, Verdict.DIVERGED),
        ([1e-2, 1e-1, 3.0], [1e-1, 3.0], 1e-14, Verdict.DIVERGED),
        ([1e-2, 5e-4, 1e-4], [1e-2, 4e-4], 1e-3, Verdict.BELOW_TRUTH),
        ([1e-2, 1e-4, 5e-7], [1e-2, 1e-4], 1e-6, Verdict.BELOW_TRUTH),  # near, but the truth is no better
        ([1e-3], [], 1e-14, Verdict.FAILED),
    ],
)
def test_by_error(errors, gaps, uncertainty, verdict):
    found, reason = judge(ladder(errors, gaps), uncertainty)
    assert found is verdict, reason
    assert reason


def test_agreement_lost_in_finer_runs_is_told():
    """Seen at a singular pose: every step from 5 ms to 0.5 ms agrees, a finer one does not."""
    verdict, reason = judge(ladder([7e-8, 6e-10, 5e-6], [7e-8, 5e-6]), 1e-14)
    assert verdict is Verdict.AGREES
    assert reason == "6.0e-10 m from the truth at step=1, and lost again: 5.0e-06 m at step=2"


def test_slow_convergence_is_no_wrong_limit():
    """First order halving: the error falls with the differences."""
    assert judge(ladder([0.8, 0.4, 0.2], [0.4, 0.2]), 0.0)[0] is Verdict.CONVERGING


def test_failures():
    blown = Rung("step=1", "non-finite", "NaN at t = 1 s")
    assert judge([blown]) == (Verdict.DIVERGED, "step=1: non-finite: NaN at t = 1 s")
    assert judge([Rung("step=1", "not-converged", "Newton")])[0] is Verdict.FAILED
    assert judge([Rung("step=1", "cannot", "no loops")]) == (Verdict.CANNOT, "no loops")


def test_a_finer_run_that_fails_is_told():
    stops = {"status": "not-converged", "message": "singular at t = 4.6 s"}
    verdict, reason = judge(ladder([1e-2, 1e-4, 1e-7], [1e-2, 1e-4], **stops), 1e-14)
    assert verdict is Verdict.AGREES
    assert "singular at t = 4.6 s" in reason
    assert judge(ladder([1e-2, 1e-3], [1e-2], **stops), 1e-14)[0] is Verdict.FAILED


def test_without_a_truth_only_convergence_to_itself_shows():
    verdict, reason = judge(ladder([None, None, None], [1e-2, 1e-4]), why_no_truth="it is chaotic")
    assert verdict is Verdict.CONVERGING
    assert "it is chaotic" in reason


def test_order_is_seen_in_its_window():
    steps = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5]
    errors = [0.5, 1e-4, 1e-8, 1e-12, 3e-9]  # too coarse, two of order 4, roundoff, worse again
    assert observed_order(steps, errors) == pytest.approx(4.0)
    assert observed_order(steps, errors, uncertainty=1e-9) is None
    assert observed_order([1e-2], [1e-4]) is None
