"""Parts of the integrators as Python runs them: exact sums, quadratures, cubics, extrapolations, steps, the pace."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from mbs_ref.integrators.loop import events, explicit
from mbs_ref.integrators.loop.leg import Pace
from mbs_ref.integrators.methods import gauss, radau
from mbs_ref.integrators.stages.gauss_coefficients import STAGES
from mbs_ref.integrators.stages.gauss_coefficients import gauss as coefficients
from mbs_ref.integrators.stages.radau_coefficients import C
from mbs_ref.integrators.stages.radau_newton import guess_stages


@pytest.mark.parametrize(("a", "b"), [(1.0, 1e-17), (1e-17, 1.0), (1e16, 3.3), (0.1, 0.2), (-1.0, 1.0 + 2.0**-52)])
def test_a_sum_and_what_it_drops_are_the_exact_sum(a, b):
    kept, dropped = gauss._two_sum.py_func(a, b)
    assert kept == a + b
    assert Fraction(kept) + Fraction(dropped) == Fraction(a) + Fraction(b)


@pytest.mark.parametrize(("a", "b"), [(0.1, 0.3), (1.0 / 3.0, 3.0), (1e8 + 0.1, 1.0 + 2.0**-40)])
def test_a_product_and_what_it_drops_are_the_exact_product(a, b):
    kept, dropped = gauss._two_product.py_func(a, b)
    assert kept == a * b
    assert Fraction(kept) + Fraction(dropped) == Fraction(a) * Fraction(b)


def test_gauss_integrates_the_polynomials_that_it_must():
    """B(16), C(8), and one degree less integrated twice (Hairer, Lubich, Wanner, sec. II.1.3); barycentric weights."""
    g = coefficients()
    for k in range(2 * STAGES):
        assert g.b @ g.c**k == pytest.approx(1.0 / (k + 1), abs=1e-15)
    for k in range(STAGES):
        np.testing.assert_allclose(g.a @ g.c**k, g.c ** (k + 1) / (k + 1), atol=1e-15)
    for k in range(STAGES - 1):
        np.testing.assert_allclose(g.abar @ g.c**k, g.c ** (k + 2) / ((k + 1) * (k + 2)), atol=1e-15)
    gaps = g.c[:, None] - g.c + np.eye(STAGES)
    np.testing.assert_allclose(g.weight, 1.0 / np.prod(gaps, axis=1), rtol=1e-12)


@pytest.mark.parametrize(("ratio", "h_last"), [(1.0, 0.1), (0.4, 0.3), (3.0, 0.02)])
def test_stages_are_guessed_on_the_cubic_of_the_last_step(ratio, h_last):
    """y from the last step's start, so that y(0) = 0, is told at its three stages."""
    cubic = np.polynomial.Polynomial([0.0, 2.0, -3.0, 5.0])  # over the last step
    newton = SimpleNamespace(z=np.array([[cubic(c)] for c in C]))
    guess_stages.py_func(newton, h_last, ratio * h_last)
    wanted = [[cubic(1.0 + ratio * c) - cubic(1.0)] for c in C]
    np.testing.assert_allclose(newton.z, wanted, rtol=1e-12)


@pytest.mark.parametrize("h", [1.0, 0.25])
@pytest.mark.parametrize("low", [0.2, -0.1])
def test_a_cubic_dips_where_its_slope_vanishes_if_it_is_negative_there(h, low):
    """g = low + (s - 0.6)^2 (s + 1) over a step, s its share: lowest at 0.6."""
    cubic = np.polynomial.Polynomial([0.36, -1.2, 1.0]) * np.polynomial.Polynomial([1.0, 1.0]) + low
    slope = cubic.deriv() / h
    found = events._dips.py_func(cubic(0.0), slope(0.0), cubic(1.0), slope(1.0), h)
    assert found == pytest.approx(0.6 if low < 0.0 else 0.0, abs=1e-12)
    table = np.full((6, 3), 1.0)  # three functions, of which the second dips
    places = events.AT_LOW, events.RATE_LOW, events.AT_NEW, events.RATE_NEW
    table[places, 1] = cubic(0.0), slope(0.0), cubic(1.0), slope(1.0)
    assert events._largest_dip.py_func(table, h) == pytest.approx(found, abs=1e-12)


@pytest.mark.parametrize(("radii", "touch"), [((0.9, 0.9), True), ((0.8, 0.9), False), ((0.0, 0.0), False)])
def test_bodies_touch_that_are_nearer_than_their_radii_together(radii, touch):
    """They are the square root of 3 m apart."""
    places = np.array([1.0, 2.0, 3.0, 2.0, 3.0, 4.0])
    assert gauss.touching.py_func(np.array(radii), places, 2) == touch


@pytest.mark.parametrize("factor", [0.5, 1.0, 1.5, 7.0])
def test_a_gauss_step_grows_by_less_than_the_error_would_bear(factor):
    run = SimpleNamespace(h=0.0)
    gauss._lengthen.py_func(run, 0.1, factor)
    assert 0.8 * min(factor, gauss.GROW) < run.h / 0.1 <= min(0.95 * factor, gauss.GROW)


@pytest.mark.parametrize(("rtol", "share"), [(1e-2, 0.03), (1e-6, 1e-3), (1e-13, 10 * 2.3e-16 / 1e-13)])
def test_radaus_newton_leaves_a_share_of_the_tolerance(rtol, share):
    """max(10 eps / rtol, min(0.03, sqrt(rtol))) (FNEWT of Hairer's RADAU5)."""
    options = SimpleNamespace(step=0.0, rtol=rtol, atol=None)
    assert radau._tolerances.py_func(options)[2] == pytest.approx(share, rel=1e-12)


@pytest.mark.parametrize(("natural", "taken"), [(3.0, 3.0), (0.0, 1.0)])
def test_away_from_a_singular_pose_steps_are_as_accuracy_allows_again(natural, taken):
    run, past = SimpleNamespace(h=1.0), explicit.Past(np.array([natural]), np.array([0, 5]))
    explicit._settle_down.py_func(run, past)
    assert (run.h, past.natural[0], past.marks[explicit.AVOIDED]) == (taken, 0.0, 0)


@pytest.mark.parametrize("start", [0.0, 1000.0])
def test_a_run_creeps_that_would_not_end_within_its_steps_whenever_it_begins(start):
    """A hundred steps for 1 s, looked at every ten: 0.11 s each is enough, 0.09 s twice is not."""
    for progress, hopeless in ((0.11, [False, False, False]), (0.09, [False, True, True])):
        pace = Pace(start, start + 1.0, 100, 10)
        assert [pace.is_hopeless(start + k * progress, 10 * k) for k in (1, 2, 3)] == hopeless
