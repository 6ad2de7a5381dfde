"""Verdicts and observed orders on made-up runs."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest

from cross_checks.judge.verdict import Control, Point, judge, limit_distance, shown_order
from cross_checks.judge.vocabulary import Verdict
from cross_checks.metrics.observed_order import observed_order


def runs(errors, gaps=(), knobs=None, **last) -> list[Point]:
    knobs = knobs or [2.0**-k for k in range(len(errors))]
    apart = [None, *gaps, *[None] * len(errors)]
    found = [Point(f"step={h:g}", h, "success", "", e, g) for h, e, g in zip(knobs, errors, apart, strict=False)]
    return [*found, Point("step=last", knobs[-1] / 2.0, **last)] if last else found


@pytest.mark.parametrize(
    ("errors", "gaps", "order", "verdict"),
    [
        ([1e-2, 1e-4, 1e-7, 1e-9], [1e-2, 1e-4, 1e-7], 4.0, Verdict.AGREES),
        ([1e-3, 2e-7], [1e-3], 4.0, Verdict.AGREES),  # one in agreement, reached at the order
        ([4e-3, 9e-7, 5e-7, 3e-2, 5e-2], [4e-3, 4e-7, 3e-2, 2e-2], 4.0, Verdict.LOST),
        ([1e-2, 2e-7, 3e-6, 1e-9, 1e-10], [1e-2, 3e-6, 3e-6, 1e-9], 4.0, Verdict.AGREES),  # once by luck
        ([4e-1, 1e-1, 2.5e-2], [3e-1, 7.5e-2], 2.0, Verdict.CONVERGING),
        ([9.0, 7.0, 4.8], [2.0, 2.2], 1.0, Verdict.NOT_SHOWN),  # falls, and is nowhere near
        ([9e-2, 7e-2, 6e-2], [2e-2, 1.5e-2], 2.0, Verdict.NOT_SHOWN),  # falls too slowly for its order
        ([2.0, 2.0, 2.0], [1e-2, 1e-3], 2.0, Verdict.WRONG_LIMIT),
        ([0.4, 0.2, 0.1], [0.2, 0.1], 1.0, Verdict.CONVERGING),  # halving is no settling
        ([2.0, 2.0, 2.0], [1.0, 1.5], 2.0, Verdict.DIVERGED),
        ([1e-2, 1e-1, 3.0], [1e-1, 3.0], 2.0, Verdict.DIVERGED),
        ([1e-3], [], 2.0, Verdict.NOT_SHOWN),
        ([1e-8], [], 2.0, Verdict.NOT_SHOWN),  # one run shows nothing, however near
    ],
)
def test_by_error(errors, gaps, order, verdict):
    found, reason = judge(runs(errors, gaps), order, 1e-14)
    assert found is verdict, reason
    assert reason


@pytest.mark.parametrize(
    ("errors", "verdict"),
    [
        ([3.3e-4, 2.1e-5, 3.1e-6, 4.3e-6], Verdict.NOT_SHOWN),  # contacts begin and end between steps: a saw about h
        ([3.3e-4, 2.1e-5, 3.1e-6, 2.0e-5], Verdict.DIVERGED),  # as far off as long before
        ([3.3e-3, 2.1e-4, 3.1e-6, 1.5e-5], Verdict.DIVERGED),  # a rise that is no bounce
        ([3.3e-4, 3.2e-6, 3.1e-6, 4.3e-6], Verdict.DIVERGED),  # a floor
    ],
)
def test_a_bounce_on_the_way_down_accuses_nobody(errors, verdict):
    """Exudyn's Runge-Kutta of order 6 on a ball that bounces, its last two steps 1.45 apart; and what is no bounce."""
    found, reason = judge(runs(errors, [None] * 3, [3.57e-4, 3.47e-5, 8.41e-6, 5.78e-6]), 6.0)
    assert found is verdict, reason
    assert ("up and down" in reason) is (verdict is Verdict.NOT_SHOWN)


def same_steps(errors, gaps, refines, knobs=None) -> list[Point]:
    points = runs(errors, gaps, knobs)
    return [replace(point, refines=more) for point, more in zip(points, refines, strict=True)]


@pytest.mark.parametrize(
    ("errors", "gaps", "refines", "verdict"),
    [
        # 85 steps, then 104 at three tolerances: two that hardly differ are no limit
        ([1e-3, 1.6e-6, 4e-4, 4e-4], [1e-3, 1e-3, 1e-3], [True, True, False, False], Verdict.NOT_SHOWN),
        # in agreement by luck, at steps that err by 4e-4 as well: nothing was reached that could be lost
        ([1e-1, 1e-2, 9e-7, 4e-4], [1e-1, 1e-2, 1e-2], [True, True, True, False], Verdict.CONVERGING),
        # three levels that settle elsewhere, one of them run twice
        ([2.0, 2.0, 2.0, 2.0], [1e-2, 1e-3, 1e-3], [True, True, True, False], Verdict.WRONG_LIMIT),
    ],
)
def test_runs_that_take_the_same_steps_are_one(errors, gaps, refines, verdict):
    found, reason = judge(same_steps(errors, gaps, refines), 1.0, 1e-14)
    assert found is verdict, reason


def test_a_setting_that_changes_nothing_is_told():
    knobs = [1e-4, 1e-6, 1e-8]
    verdict, reason = judge(same_steps([0.3] * 3, [0.0] * 2, [True, False, False], knobs), 1.0, 1e-14)
    assert verdict is Verdict.DIVERGED
    assert "with the same steps from step=0.0001 to step=1e-08" in reason


@pytest.mark.parametrize(
    ("errors", "gaps", "rounding", "verdict"),
    [
        # falls by its order down to rounding, and lies there: rounding is not accused
        ([4e-2, 2e-2, 1e-2, 4e-3, 4e-3], [2e-2, 1e-2, 6e-3, 1e-5], 5e-3, Verdict.CONVERGING),
        ([4e-2, 2e-2, 1e-2, 4e-3, 5e-3], [2e-2, 1e-2, 6e-3, 1e-3], 5e-3, Verdict.CONVERGING),
        ([1e-4, 9e-7, 5e-6], [1e-4, 5e-6], 6e-6, Verdict.NOT_SHOWN),  # agreement lost to rounding; one run is left
        ([2e-3, 2e-3, 2e-3], [1e-5, 1e-6], 5e-3, Verdict.NOT_SHOWN),  # never above it
        # what rounding cannot explain is accused all the same
        ([4e-2, 2e-2, 2e-2, 2e-2], [2e-2, 1e-4, 1e-5], 5e-3, Verdict.WRONG_LIMIT),
        ([1e-2, 1e-1, 3.0], [1e-1, 3.0], 5e-3, Verdict.DIVERGED),
        ([1e-3, 2e-7, 1e-7], [1e-3, 1e-7], 5e-3, Verdict.AGREES),  # better than it may be
    ],
)
def test_rounding_is_not_accused(errors, gaps, rounding, verdict):
    points = [replace(point, rounding=rounding) for point in runs(errors, gaps)]
    found, reason = judge(points, 1.0, 1e-14)
    assert found is verdict, reason
    set_aside = errors[-1] <= rounding and verdict is not Verdict.AGREES
    assert (f"rounding may have left {rounding:.1e}" in reason) == set_aside


@pytest.mark.parametrize(
    ("errors", "gaps", "off", "verdict"),
    [
        ([2.7, 2.9, 3.0], [2.0, 3.1], 3.2, Verdict.NOT_SHOWN),  # two strangers on a motion that amplifies errors
        ([2.7, 2.9, 3.0], [2.0, 3.1], 1e-3, Verdict.DIVERGED),  # the other gets there
        ([1e-2, 1e-1, 50.0], [1e-1, 50.0], 3.0, Verdict.DIVERGED),  # farther than any motion goes
        ([5e-2, 6e-2, 7e-2], [3e-2, 3e-2], 3.0, Verdict.DIVERGED),  # near, and no nearer with finer steps
        ([2.0, 2.0, 2.0], [1e-2, 1e-3], 3.0, Verdict.WRONG_LIMIT),  # a limit of its own needs no control
    ],
)
def test_runs_that_a_control_does_no_better_are_not_accused(errors, gaps, off, verdict):
    found, reason = judge(runs(errors, gaps), 1.0, 1e-14, control=Control("other euler", off))
    assert found is verdict, reason
    assert ("where other euler is 3.2e+00 off" in reason) == (verdict is Verdict.NOT_SHOWN)


@pytest.mark.parametrize(
    ("errors", "gaps", "status", "further", "verdict"),
    [
        ([2.0, 2.0, 2.0], [1e-2, 1e-3], "success", 0.9, Verdict.NOT_SHOWN),  # it was no limit
        ([2.0, 2.0, 2.0], [1e-2, 1e-3], "success", 1.9, Verdict.WRONG_LIMIT),
        ([2.7, 2.9, 3.0], [2.0, 3.1], "success", 0.7, Verdict.NOT_SHOWN),
        ([2.7, 2.9, 3.0], [2.0, 3.1], "success", 3.1, Verdict.DIVERGED),
        ([2.7, 2.9, 3.0], [2.0, 3.1], "non-finite", None, Verdict.DIVERGED),
        ([1e-2, 9e-7, 5e-5], [1e-2, 5e-5], "success", 1e-9, Verdict.LOST),  # what was lost was lost
        ([4e-1, 1e-1, 2.5e-2], [3e-1, 7.5e-2], "success", 1e-9, Verdict.CONVERGING),  # accused of nothing
    ],
)
def test_a_finer_run_refutes_an_accusation_or_leaves_it(errors, gaps, status, further, verdict):
    appeal = Point("step=finer", 1e-3, status, "", further)
    found, reason = judge(runs(errors, gaps), 2.0, 1e-14, appeal=appeal)
    assert found is verdict, reason
    assert ("step=finer" in reason) == (verdict is Verdict.NOT_SHOWN)


def test_what_blew_up_at_its_finest_is_acquitted_by_no_appeal():
    points = runs([2.7, 2.9, 3.0], [2.0, 3.1], status="non-finite", message="NaN")
    assert judge(points, 2.0, 1e-14, appeal=Point("step=finer", 1e-3, "success", "", 0.1))[0] is Verdict.DIVERGED


def test_a_truth_that_knows_no_better_judges_nothing():
    assert judge(runs([1e-2, 5e-4, 1e-4], [1e-2, 4e-4]), 2.0, 1e-3)[0] is Verdict.BELOW_TRUTH
    assert judge(runs([1e-2, 1e-4, 5e-7], [1e-2, 1e-4]), 4.0, 1e-6)[0] is Verdict.BELOW_TRUTH


def test_the_limit_follows_from_the_gaps():
    """Errors C h^2 + b: gaps are C (h1^2 - h2^2), and the finest run is C h^2 from the limit."""
    knobs, c = [0.4, 0.2, 0.1], 3.0
    gaps = [c * (a * a - b * b) for a, b in itertools.pairwise(knobs)]
    points = runs([1.0 + c * h * h for h in knobs], gaps, knobs)
    assert limit_distance(points, 2.0) == pytest.approx(c * knobs[-1] ** 2, rel=1e-9)


def test_the_order_that_gaps_show_heeds_how_far_settings_are_apart():
    """Drake's CENIC on a swing: the first gap is wide because 455 lies between the tolerances, and 16 after."""
    knobs, order, c = [1e-5, 2.2e-8, 1.4e-9], 0.45, 1.0
    values = [c * knob**order for knob in knobs]
    gaps = [a - b for a, b in itertools.pairwise(values)]
    points = runs(values, gaps, knobs)
    assert shown_order(knobs[0] / knobs[1], knobs[1] / knobs[2], gaps[0] / gaps[1]) == pytest.approx(order)
    assert limit_distance(points, 0.5) == pytest.approx(values[-1], rel=1e-9)
    assert judge(points, 0.5, 1e-14)[0] is Verdict.CONVERGING
    assert shown_order(2.0, 2.0, 0.9) is None


def test_failures():
    blown = Point("step=1", 1.0, "non-finite", "NaN at t = 1 s")
    assert judge([blown]) == (Verdict.DIVERGED, "step=1: non-finite: NaN at t = 1 s")
    assert judge([Point("step=1", 1.0, "not-converged", "Newton")])[0] is Verdict.FAILED
    assert judge([Point("step=1", 1.0, "cannot", "no loops")]) == (Verdict.CANNOT, "no loops")
    refused = Point("step=1", 1.0, "cannot", "step = 1 s is beyond what rk4 can bear")
    assert judge([refused, *runs([1e-4, 1e-7, 1e-9], [1e-4, 1e-7])], 4.0, 1e-14)[0] is Verdict.AGREES


def test_a_finer_run_that_fails_is_told():
    stops = {"status": "not-converged", "message": "singular at t = 4.6 s"}
    verdict, reason = judge(runs([1e-2, 1e-4, 1e-7, 1e-9], [1e-2, 1e-4, 1e-7], **stops), 4.0, 1e-14)
    assert verdict is Verdict.AGREES
    assert "singular at t = 4.6 s" in reason
    assert judge(runs([1e-2], **stops), 4.0, 1e-14)[0] is Verdict.FAILED


def test_without_a_truth_only_convergence_to_itself_shows():
    verdict, reason = judge(runs([None, None, None], [1e-2, 1e-4]), 2.0, why_no_truth="it is chaotic")
    assert verdict is Verdict.CONVERGING
    assert "it is chaotic" in reason


def test_order_is_seen_in_its_window():
    steps = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5]
    errors = [0.5, 1e-4, 1e-8, 1e-12, 3e-9]  # too coarse, two of order 4, roundoff, worse again
    assert observed_order(steps, errors) == pytest.approx(4.0)
    assert observed_order(steps, errors, uncertainty=1e-9) is None
    assert observed_order([1e-2], [1e-4]) is None


def test_order_is_not_read_from_what_rounding_may_leave():
    steps = [0.1, 0.05, 0.025, 0.0125, 0.00625]
    errors = [h**2 for h in steps[:3]] + [5e-4, 4e-4]  # second order down to rounding
    assert observed_order(steps, errors) < 1.0
    assert observed_order(steps, errors, rounding=[6e-4] * 5) == pytest.approx(2.0)
    assert observed_order(steps, errors, rounding=[2e-3] * 5) is None  # two coarse ones are left
