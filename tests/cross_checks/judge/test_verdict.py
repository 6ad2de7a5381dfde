"""Verdicts on prescribed errors and gaps: the word, and the odds that it is false."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from cross_checks.judge.bounds import SCATTER
from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import Posterior, posterior
from cross_checks.judge.verdict import Judgement, Point, judge
from cross_checks.judge.vocabulary import Verdict


def points_of(errors, knobs=None, steps=None, rounding=0.0, **last) -> list[Point]:
    knobs = knobs or [2.0**-k for k in range(len(errors))]
    steps = steps or [int(100 / knob) for knob in knobs]
    each = zip(knobs, errors, steps, strict=True)
    runs = [Point(f"step={h:g}", h, "success", "", e, n, rounding) for h, e, n in each]
    return [*runs, Point("step=last", knobs[-1] / 2.0, **last)] if last else runs


def shown(points, gaps=(), order=1.0, uncertainty=1e-14) -> Posterior:
    """Return the posterior of runs of fixed steps; the gap of two distant runs is the largest between them."""
    good = [point for point in points if point.ok]
    apart = np.zeros((len(good), len(good)))
    for i, j in itertools.combinations(range(len(good)), 2):
        apart[i, j] = apart[j, i] = max(gaps[i:j]) if gaps else np.hypot(good[i].error, good[j].error)
    typical = np.log10(max(good[0].error or 1.0, 1e-15))
    facts = {"kind": "fixed", "order": order, "reference": good[0].knob, "typical": typical, "spread": 1.0}
    runs = [(point.knob, point.error, point.steps, point.rounding) for point in good]
    return posterior(Ladder.of(runs, apart, uncertainty=uncertainty, **facts))


def verdict(errors, gaps=(), order=1.0, uncertainty=1e-14, **facts) -> Judgement:
    points = points_of(errors, **facts)
    return judge(points, shown(points, gaps, order, uncertainty), order)


# The row, the word, and where the word differs from a rule-based one the reason.
@pytest.mark.parametrize(
    ("errors", "gaps", "order", "word"),
    [
        ([1e-2, 1e-4, 1e-7, 1e-9], [1e-2, 1e-4, 1e-7], 4.0, Verdict.AGREES),
        ([1e-3, 2e-7], [1e-3], 4.0, Verdict.AGREES),  # one in agreement, reached at the order: odds 0.05
        ([1e-2, 2e-7, 3e-6, 1e-9, 1e-10], [1e-2, 3e-6, 3e-6, 1e-9], 4.0, Verdict.AGREES),  # once by luck
        ([4e-1, 1e-1, 2.5e-2], [3e-1, 7.5e-2], 2.0, Verdict.NOT_SHOWN),  # three unknowns fit any three levels
        ([4e-1, 1e-1, 2.5e-2, 6e-3], [3e-1, 7.5e-2, 2e-2], 2.0, Verdict.CONVERGING),
        ([0.4, 0.2, 0.1, 0.05], [0.2, 0.1, 0.05], 1.0, Verdict.CONVERGING),  # halving is no settling
        ([9.0, 7.0, 4.8], [2.0, 2.2], 1.0, Verdict.NOT_SHOWN),  # falls, and is nowhere near
        ([9e-2, 7e-2, 6e-2], [2e-2, 1.5e-2], 2.0, Verdict.NOT_SHOWN),  # odds of 0.74 of an order below a half
        ([2.0, 2.0, 2.0], [1e-2, 1e-3], 2.0, Verdict.WRONG_LIMIT),
        ([0.3] * 4, [0.0] * 3, 1.0, Verdict.WRONG_LIMIT),  # bitwise equal runs that take ever more steps
        ([1e-3], [], 2.0, Verdict.NOT_SHOWN),
        ([1e-8], [], 2.0, Verdict.NOT_SHOWN),  # one run shows nothing, however near
        # Three or four runs leave odds of a failure below 0.95, so that more are requested before a classification:
        ([4e-3, 9e-7, 5e-7, 3e-2, 5e-2], [4e-3, 4e-7, 3e-2, 2e-2], 4.0, Verdict.NOT_SHOWN),  # 0.90
        ([2.0, 2.0, 2.0], [1.0, 1.5], 2.0, Verdict.NOT_SHOWN),  # 0.18: too coarse, or amplified
        ([1e-2, 1e-1, 3.0], [1e-1, 3.0], 2.0, Verdict.NOT_SHOWN),  # 0.54
        # ... and given:
        ([4e-3, 9e-7, 5e-7, 3e-2, 5e-2, 4e-2, 3e-2], [4e-3, 4e-7, 3e-2, 5e-2, 5e-2, 5e-2], 4.0, Verdict.LOST),
        ([1e-2, 1e-1, 0.8, 1.5, 1.7, 1.9], [1e-1, 0.8, 2.0, 2.0, 2.0], 2.0, Verdict.NOT_SHOWN),  # 0.56: or amplified
    ],
)
def test_by_error(errors, gaps, order, word):
    found = verdict(errors, gaps, order)
    assert found.verdict is word, found
    assert found.reason
    assert (found.odds is None) == (word is Verdict.NOT_SHOWN)
    assert found.odds is None or 0.0 < found.odds < 0.1


def test_errors_that_neither_fall_nor_settle_over_three_decades_diverge():
    errors, gaps = [3e-3, 8e-4, 2e-3, 1e-3, 3e-3, 9e-4, 2e-3], [3e-3, 2e-3, 2e-3, 3e-3, 3e-3, 2e-3]
    knobs = [10.0 ** (-0.5 * k) for k in range(7)]
    assert verdict(errors, gaps, 2.0, knobs=knobs).verdict is Verdict.DIVERGED
    assert verdict(errors, gaps, 2.0).verdict is Verdict.NOT_SHOWN  # over 1.8 decades: odds of 0.84


def test_runs_that_blow_up_are_one_loss_however_far_they_go():
    """An instability from some step count on: by size alone, each such run would be a stray of its own."""
    errors = [1e-5, 1e-7, 1e-9, 3e3, 1e7, 1e11]
    assert verdict(errors, [1e-5, 1e-7, *errors[3:]], 6.0).verdict is Verdict.LOST


@pytest.mark.parametrize(
    ("errors", "word"),
    [
        ([3.3e-4, 2.1e-5, 3.1e-6, 4.3e-6], Verdict.CONVERGING),  # contacts between steps: first order within scatter
        ([3.3e-4, 2.1e-5, 3.1e-6, 2.0e-5], Verdict.NOT_SHOWN),  # a coarser setting is better
        ([3.3e-4, 3.2e-6, 3.1e-6, 4.3e-6], Verdict.NOT_SHOWN),  # odds of 0.47 that errors stall
    ],
)
def test_one_rise_at_the_finest_of_four_runs_classifies_nothing(errors, word):
    """Exudyn's Runge-Kutta of order 6 on a ball that bounces, its last two steps 1.45 apart."""
    found = verdict(errors, order=6.0, knobs=[3.57e-4, 3.47e-5, 8.41e-6, 5.78e-6])
    assert found.verdict is word, found


@pytest.mark.parametrize("levels", [3, 4, 5, 6])
@pytest.mark.parametrize("off", [1e-4, 2e-2, 1.0])
def test_one_outlier_at_the_finest_run_classifies_nothing_as_wrong(levels, off):
    errors = [4e-3 * 10.0 ** (-2.0 * k) for k in range(levels)] + [off]
    found = verdict(errors, [*errors[:-2], off], 4.0, knobs=[10.0 ** (-0.5 * k) for k in range(levels + 1)])
    assert found.verdict in (Verdict.NOT_SHOWN, Verdict.CONVERGING), found


@pytest.mark.parametrize(
    ("errors", "gaps", "steps", "word"),
    [
        # 85 steps, then 104 at three tolerances: two that hardly differ are no limit
        ([1e-3, 1.6e-6, 4e-4, 4e-4], [1e-3, 1e-3, 1e-3], [85, 104, 104, 104], Verdict.NOT_SHOWN),
        # in agreement by luck, at steps that err by 4e-4 as well: nothing was reached that could be lost
        ([1e-1, 1e-2, 9e-7, 4e-4], [1e-1, 1e-2, 1e-2], [10, 20, 40, 40], Verdict.NOT_SHOWN),  # odds of a limit 0.13
        # three levels that settle elsewhere, one of them run twice
        ([2.0, 2.0, 2.0, 2.0], [1e-2, 1e-3, 1e-3], [10, 20, 40, 40], Verdict.WRONG_LIMIT),
        ([0.3] * 3, [0.0] * 2, [50] * 3, Verdict.NOT_SHOWN),  # outputs set all steps: one level
    ],
)
def test_runs_that_take_the_same_steps_are_one_level(errors, gaps, steps, word):
    found = verdict(errors, gaps, steps=steps)
    assert found.verdict is word, found


@pytest.mark.parametrize(
    ("errors", "gaps", "rounding", "word"),
    [
        # falls by its order down to rounding, and stays there
        ([4e-2, 2e-2, 1e-2, 4e-3, 4e-3], [2e-2, 1e-2, 6e-3, 1e-5], 5e-3, Verdict.CONVERGING),
        ([4e-2, 2e-2, 1e-2, 4e-3, 5e-3], [2e-2, 1e-2, 6e-3, 1e-3], 5e-3, Verdict.CONVERGING),
        ([1e-4, 9e-7, 5e-6], [1e-4, 5e-6], 6e-6, Verdict.NOT_SHOWN),  # agreement lost to rounding; one run is left
        ([2e-3, 2e-3, 2e-3], [1e-5, 1e-6], 5e-3, Verdict.NOT_SHOWN),  # never above it
        ([1e-3, 2e-7, 1e-7], [1e-3, 1e-7], 5e-3, Verdict.AGREES),  # better than it may be
        # what rounding cannot explain
        ([2.0, 2.0, 2.0, 2.0], [2e-2, 1e-3, 1e-4], 5e-3, Verdict.WRONG_LIMIT),
    ],
)
def test_rounding_explains_errors_within_it(errors, gaps, rounding, word):
    found = verdict(errors, gaps, rounding=rounding)
    assert found.verdict is word, found
    set_aside = errors[-1] <= SCATTER * rounding and word is not Verdict.AGREES
    assert ("rounding may explain" in found.reason) == set_aside


def test_a_truth_that_knows_no_better_judges_nothing():
    assert verdict([1e-2, 5e-4, 1e-4], [1e-2, 4e-4], 2.0, 1e-3).verdict is Verdict.BELOW_TRUTH
    assert verdict([1e-2, 1e-4, 5e-7], [1e-2, 1e-4], 4.0, 1e-6).verdict is Verdict.BELOW_TRUTH


def test_failures():
    """Three settings that fail classify a method; two may both be unlucky."""
    blown = [Point(f"step={h:g}", h, "non-finite", "NaN at t = 1 s") for h in (4.0, 2.0, 1.0)]
    assert judge(blown, None)[:2] == (Verdict.DIVERGED, "step=1: non-finite: NaN at t = 1 s")
    assert judge([replace(point, status="not-converged") for point in blown], None).verdict is Verdict.FAILED
    assert judge(blown[:2], None).verdict is Verdict.NOT_SHOWN
    assert judge([Point("step=1", 1.0, "cannot", "no loops")], None)[:2] == (Verdict.CANNOT, "no loops")
    refused = Point("step=1", 1.0, "cannot", "step = 1 s is beyond the stability limit of rk4")
    points = [refused, *points_of([1e-4, 1e-7, 1e-9])]
    assert judge(points, shown(points, [1e-4, 1e-7], 4.0), 4.0).verdict is Verdict.AGREES


def test_a_finer_run_that_fails_is_reported():
    stops = {"status": "not-converged", "message": "singular at t = 4.6 s"}
    found = verdict([1e-2, 1e-4, 1e-7, 1e-9], [1e-2, 1e-4, 1e-7], 4.0, **stops)
    assert found.verdict is Verdict.AGREES
    assert "singular at t = 4.6 s" in found.reason
    assert verdict([1e-2], [], 4.0, **stops).verdict is Verdict.NOT_SHOWN  # one failure classifies nothing


def test_without_a_truth_only_convergence_to_itself_shows():
    points = points_of([None, None, None])
    found = judge(points, shown(points, [1e-2, 1e-4], 2.0), why_no_truth="it is chaotic")
    assert found.verdict is Verdict.CONVERGING
    assert "it is chaotic" in found.reason
