"""The convergence model on ladders of vectors whose law is known."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.judge.convergence.ladder import Ladder
from cross_checks.judge.convergence.model import posterior
from cross_checks.judge.convergence.prediction import odds_below, probability_below


def ladder(steps, order, scatter=0.0, turn=0.0, off=0.0, expected=None, seed=0, **facts) -> Ladder:
    """Return runs x(h) = D + C h^p z of 50 components, with C = 0.3."""
    rng = np.random.default_rng(seed)
    first, limit = rng.normal(size=50), off * np.eye(50)[0]
    states = []
    for h in steps:
        z = first + turn * rng.normal(size=50)
        states.append(limit + 0.3 * 10.0 ** (scatter * rng.normal()) * h**order * z / np.abs(z).max())
    x = np.array(states)
    h = np.array(steps)
    usual = {"typical": float(np.log10(0.3 * h[0] ** order)), "reference": h[0], "uncertainty": 1e-15} | facts
    return Ladder(
        h, np.abs(x).max(axis=1), np.abs(x[:, None] - x).max(axis=2), (1.0 / h).astype(int), np.full(len(h), 1e-16),
        "fixed", expected or order, **usual,
    )  # fmt: skip


HALVED = [0.1, 0.05, 0.02, 0.01]


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0, 8.0])
def test_the_order_of_a_clean_law_is_observed(order):
    shown = posterior(ladder(HALVED, order))
    assert shown.observed_order == pytest.approx(order, rel=0.1)
    assert shown.weights["right"] > 0.9


def test_an_order_other_than_documented_is_observed():
    assert posterior(ladder(HALVED, 1.0, expected=4.0)).observed_order == pytest.approx(1.0, abs=0.15)


def test_one_run_observes_no_order():
    assert posterior(ladder([0.1], 2.0)).observed_order is None
    with pytest.raises(ValueError, match="needs one run"):
        posterior(ladder([0.1], 2.0).take(slice(0)))


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("off", [1e-3, 0.1])
def test_a_limit_of_its_own_is_located(order, off):
    shown = posterior(ladder([0.1, 0.05, 0.02, 0.01, 0.004, 0.001], order, off=off, turn=0.2, scatter=0.05))
    if order == 1.0 and off == 1e-3:
        assert shown.odds_of_limit(1e-6) > 0.35  # the finest run is 3e-4 from it
    else:
        assert shown.odds_of_limit(1e-6) > 0.95
    assert shown.limit_distance == pytest.approx(off, rel=0.5)


def test_a_limit_far_below_the_errors_neither_raises_nor_lowers_its_odds():
    """Both hypotheses explain such runs alike, so that the odds stay those of the prior or less."""
    for seed in range(12):
        shown = posterior(ladder(HALVED, 2.0, scatter=0.1, turn=0.3, seed=seed))
        assert shown.weights["limit"] < 0.35
        assert shown.odds_of_limit(0.3 * shown.ladder.errors[-1]) < 0.25


def test_errors_at_random_heights_stall():
    rng = np.random.default_rng(3)
    x = 10.0 ** rng.uniform(-4.0, -2.0, size=(10, 1)) * rng.normal(size=(10, 50))
    plain = ladder(np.geomspace(0.1, 1e-4, 10), 4.0)
    random = Ladder(
        plain.settings, np.abs(x).max(axis=1), np.abs(x[:, None] - x).max(axis=2), plain.steps, plain.rounding, "fixed",
        4.0, 0.1, -3.0,
    )  # fmt: skip
    shown = posterior(random)
    slow = shown.weights["right"] * shown.odds_of_order_below(0.5)
    assert shown.odds_of_stall(1e-6) + slow > 0.95


def test_predictions_follow_the_law():
    shown = posterior(ladder(HALVED, 4.0))
    reaches = 0.3 ** (-1 / 4) * 1e-12 ** (1 / 4)  # the step of an error of 1e-12
    odds = odds_below(shown, np.array([2.0 * reaches, reaches / 1.5]), 1e-12)
    assert odds[0] < 0.1
    assert odds[1] > 0.8
    assert probability_below(np.array([0.0, 30.0])) == pytest.approx([0.5, 1.0], abs=1e-5)


def test_runs_of_equal_steps_are_one_level_and_its_largest_error_stands():
    plain = ladder(HALVED, 2.0)
    same = Ladder(**(vars(plain) | {"steps": np.array([10, 20, 20, 20])})).levels()
    assert same.settings.tolist() == [0.1, 0.01]
    assert same.errors.tolist() == plain.errors[:2].tolist()


def test_of_coarse_runs_unrelated_to_the_truth_the_finest_counts():
    plain = ladder([3.0, 2.5, 2.0, 0.1, 0.05], 2.0)
    assert plain.errors[2] > 0.5
    assert plain.levels().settings.tolist() == [2.0, 0.1, 0.05]
