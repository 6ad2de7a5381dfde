"""The synthetic methods have the answers that they state."""

from __future__ import annotations

import numpy as np
import pytest

from tests.cross_checks.convergence.law import OUTPUTS, size
from tests.cross_checks.convergence.synthetic import BAR, CALIBRATION, HELD_OUT, TENFOLD, draw

METHODS = {family: [draw(seed, family) for seed in range(300)] for family in (CALIBRATION, HELD_OUT)}
EVERY = [method for methods in METHODS.values() for method in methods]


def errors(method, count=16):
    """Return the errors of the runs that succeed, coarse to fine, over the whole range."""
    runs = [method.run(float(s)) for s in np.geomspace(method.coarsest, method.finest, count)]
    return np.array([size(run.state) for run in runs if run.state is not None])


@pytest.mark.parametrize("family", [CALIBRATION, HELD_OUT])
def test_a_family_has_its_shares_of_every_category(family):
    assert sum(category.share for category in family) == pytest.approx(1.0)
    for label, share in (("correct", 0.74), ("wrong-limit", 0.20), ("never", 0.06)):
        assert sum(c.share for c in family if c.label == label) == pytest.approx(share)
    assert {method.category for method in METHODS[family]} == {category.name for category in family}


def test_the_same_seed_and_setting_give_the_same_run_bit_by_bit():
    for family, methods in METHODS.items():
        for seed in range(40):
            setting = methods[seed].coarsest / 7.3
            first, again = methods[seed].run(setting), draw(seed, family).run(setting)
            assert (first.status, first.steps) == (again.status, again.steps)
            assert np.array_equal(first.state, again.state) if first.state is not None else again.state is None


def test_a_limit_is_wrong_exactly_where_the_label_states_it():
    for method in EVERY:
        bar = max(BAR, TENFOLD * method.uncertainty)
        assert (method.limit_distance > bar) == (method.label == "wrong-limit"), method.category


def test_errors_of_correct_methods_fall_except_where_rounding_rules():
    for method in EVERY[::3]:
        fallen = errors(method)
        rounding = 1e7 * method.roundoff * method.amplification + method.uncertainty
        if method.label == "correct" and method.category != "chaos" and rounding < 1e-6 and len(fallen) > 5:
            assert min(fallen[-3:]) < max(0.05 * max(fallen), BAR), method.category


def test_wrong_limits_are_approached_and_never_passed():
    settled = 0
    for method in EVERY:
        if method.label == "wrong-limit" and method.roundoff < 1e-10 and len(shown := errors(method)):
            settled += abs(shown[-1] / method.limit_distance - 1.0) < 0.2
            assert shown[-1] > 0.3 * method.limit_distance, method.category
    assert settled > 0.7 * sum(method.label == "wrong-limit" for method in EVERY)


def test_methods_that_never_converge_are_far_off_at_the_fine_end():
    for method in EVERY:
        if method.label == "never":
            shown = errors(method)
            runs = [method.run(float(s)).status for s in np.geomspace(method.coarsest, method.finest, 25)]
            assert max(shown[-5:]) > 10.0 * BAR or runs[-1] == "non-finite", method.category


def test_runs_of_tolerances_that_outputs_determine_are_equal_bit_by_bit():
    equal = 0
    for method in EVERY:
        first, second = method.run(1e-2), method.run(5e-3)
        if method.kind == "adaptive" and first.steps == second.steps and {first.status, second.status} == {"success"}:
            equal += np.array_equal(first.state, second.state)
            assert first.steps >= OUTPUTS, method.category
            assert np.array_equal(first.state, second.state) or first.steps > OUTPUTS, method.category
    assert equal > 20


def test_errors_on_a_plateau_stay_within_a_factor_of_ten_over_a_decade():
    for method in EVERY:
        if method.category == "plateau":
            coarse, finer = (size(method.run(setting).state) for setting in (1e-2, 1e-3))
            assert 0.1 < coarse / finer < 10.0


def test_a_method_that_ignores_its_setting_repeats_its_run_at_every_step_count():
    for method in EVERY:
        if method.category == "bitwise equal, wrong":
            first, last = method.run(method.coarsest), method.run(method.finest)
            assert np.array_equal(first.state, last.state)
            assert first.steps < last.steps
