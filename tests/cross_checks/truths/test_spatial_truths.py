"""Converged truths in space against the reference solver, whose Euler parameters take no part in them."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.made_by.mechanisms.spherical_tree import hamilton, newton_euler, spherical_tree, turned
from cross_checks.truths.made_by.numerics.closed_forms import periodic_integral
from cross_checks.truths.of import tops
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.observables.distance import farthest
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate


@pytest.mark.parametrize(
    ("name", "parameters", "end", "bound"),
    [
        ("bricard", {}, 0.2, 1e-11),
        ("spatial_slider_crank", {}, 0.2, 1e-10),
        pytest.param("spatial_chain", {"links": 3}, 0.1, 1e-10, marks=pytest.mark.slow),
        pytest.param("double_gyroscope", {}, 0.1, 1e-11, marks=pytest.mark.slow),
        ("flyball_governor", {}, 0.05, 1e-9),
    ],
)
def test_truths_and_the_reference_agree(name, parameters, end, bound):
    """Minimal coordinates against Euler parameters with constraints: positions (m) and orientations (rad)."""
    scene = scenes.make(name, **parameters)
    times = np.linspace(0.0, end, 3)
    truth = seek_truth(scene, times, afresh=True)  # not what is kept of the whole run
    assert isinstance(truth, Truth)
    assert truth.kind == "converged"
    assert truth.uncertainty < 1e-12
    own = simulate(scene, Settings(rtol=1e-12, reactions=False, estimate="off"), times)
    assert own.ok, own.message
    assert max(farthest(scene, own, truth)[:2]) < bound


def test_both_formulations_of_a_spherical_tree_turn_alike():
    """p = M omega has the rate that Newton's and Euler's equations give, by a difference along the motion."""
    tree = spherical_tree(scenes.make("double_gyroscope"))
    newton, momenta = newton_euler(tree), hamilton(tree)
    y = newton.start + 0.1 * np.random.default_rng(1).standard_normal(len(newton.start))
    y[:8] = (y[:8].reshape(4, 2) / np.linalg.norm(y[:8].reshape(4, 2), axis=0)).ravel()

    def with_momenta(x):
        return np.concatenate([x[:8], turned(tree, x[:8].reshape(4, 2))[2] @ x[8:]])

    h = 1e-6
    slope = newton.derivative(0.0, y)
    rate = (with_momenta(y + h * slope) - with_momenta(y - h * slope)) / (2.0 * h)
    np.testing.assert_allclose(momenta.derivative(0.0, with_momenta(y)), rate, rtol=1e-6, atol=1e-6)


def test_whole_periods_of_a_rate_are_counted_not_integrated():
    """The integral of cos^2 t is t / 2 + sin 2t / 4; over 1e6 periods nobody integrates it piece by piece."""
    times = np.array([0.0, 1.0, 4.0, 3e6], dtype=np.longdouble)
    found, error = periodic_integral(lambda t: np.cos(t) ** 2, times, 0.5, 4 * np.arctan(np.longdouble(1.0)))
    assert np.max(np.abs(found - (times / 2 + np.sin(2 * times) / 4))) < 1e-12
    assert error < 1e-12


def test_a_free_top_is_known_after_ten_thousand_turns():
    scene = scenes.make("torque_free_top", spin=10.0, axis=3, tilt=0.1, turns=10_000.0)
    found = tops.torque_free_top(scene, np.linspace(0.0, 2000.0 * np.pi, 11))
    assert found.uncertainty < 1e-10
    assert np.max(np.abs(np.linalg.norm(found.orientation, axis=2) - 1.0)) < 1e-15
