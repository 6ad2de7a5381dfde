"""The fixed part of the calibration: verdicts on synthetic methods of a family that the priors were not fitted to."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.judge.bounds import AGREEMENT
from cross_checks.judge.convergence import calibration, model
from tests.cross_checks.convergence.measure import evaluate, report
from tests.cross_checks.convergence.searched import Searched, classify
from tests.cross_checks.convergence.synthetic import HELD_OUT, draw

METHODS = 40  # of seeds that the kept calibration does not hold
FIRST = 100_000


def test_verdicts_on_held_out_methods():
    groups = report(evaluate(classify, HELD_OUT, range(FIRST, FIRST + METHODS)))["groups"]
    assert groups["correct"].get("called wrong", 0) == 0
    assert groups["correct"].get("open", 0) <= 0.1 * groups["correct"]["methods"]
    assert groups["wrong-limit, shown"].get("passed", 0) == 0
    assert groups["wrong-limit, shown"]["called wrong"] >= 0.85 * groups["wrong-limit, shown"]["methods"]


def test_the_kept_calibration_holds_the_bounds():
    """Of at least 10 000 methods: what the method page shows."""
    kept = calibration()
    assert sum(figures["methods"] for figures in kept.values()) >= 10_000
    for figures in kept.values():
        groups = figures["groups"]
        assert figures["called wrong on one run"] == 0
        assert groups["correct"].get("called wrong", 0) <= 0.002 * groups["correct"]["methods"]
        assert groups["wrong-limit, shown"].get("passed", 0) <= 0.02 * groups["wrong-limit, shown"]["methods"]
        assert groups["wrong-limit, shown"]["called wrong"] >= 0.85 * groups["wrong-limit, shown"]["methods"]
        assert groups["never, shown"].get("passed", 0) <= 0.03 * groups["never, shown"]["methods"]
        assert groups["never, shown"]["called wrong"] >= 0.6 * groups["never, shown"]["methods"]


# Factors of bins (docs/theory.md).
BEYOND = {"calibration": {(0.01, 0.1): 2.2}, "held-out": {(0.01, 0.1): 2.1, (0.3, 0.7): 3.1}}


@pytest.mark.parametrize("family", BEYOND)
def test_the_kept_odds_come_true_within_a_factor_2_but_for_known_bins(family):
    rows = calibration()[family]["odds of a wrong limit"]
    beyond = {(row["from"], row["to"]): row["came true"] / row["stated"] for row in rows if row["within 2"] is False}
    assert beyond.keys() == BEYOND[family].keys()
    for ends, factor in beyond.items():
        assert abs(math.log(factor)) <= math.log(BEYOND[family][ends])


@pytest.mark.parametrize("seed", [FIRST + 2, FIRST + 3, FIRST + 6])
def test_sums_in_single_precision_give_the_odds_of_double_precision(monkeypatch, seed):
    search = Searched(draw(seed, HELD_OUT))
    for setting in np.geomspace(search.coarsest, search.finest, 4):
        search.try_(search.typed(float(setting)))
    shown = search.shown()
    assert shown is not None
    assert max(shown.weights.values()) < 0.95  # certain odds would be equal in any precision
    monkeypatch.setattr(model, "REAL", np.float64)
    for name in ("WIDTHS", "LEVELS"):
        monkeypatch.setattr(model, name, getattr(model, name).astype(np.float64))
    exact = model.posterior(shown.ladder)
    assert shown.weights == pytest.approx(exact.weights, abs=1e-5)
    for odds in ("odds_of_limit", "odds_of_stall", "odds_of_order_below"):
        assert getattr(shown, odds)(AGREEMENT) == pytest.approx(getattr(exact, odds)(AGREEMENT), abs=1e-5)
