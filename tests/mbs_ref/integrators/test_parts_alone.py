"""Parts of the integrators as Python runs them: exact sums, quadratures, cubics, extrapolations, steps, the pace."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from mbs_ref.integrators.loop import events, explicit, step
from mbs_ref.integrators.loop.leg import Pace
from mbs_ref.integrators.methods import gauss, generalized_alpha, radau
from mbs_ref.integrators.stages.gauss_coefficients import STAGES
from mbs_ref.integrators.stages.gauss_coefficients import gauss as coefficients
from mbs_ref.integrators.stages.radau_newton import C, guess_stages
from mbs_ref.kernels.contact.laws import RATE, VALUE


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


@pytest.mark.parametrize("start", [0.0, 1000.0])
def test_a_run_creeps_that_would_not_end_within_its_steps_whenever_it_begins(start):
    """A hundred steps for 1 s, looked at every ten: 0.11 s each is enough, 0.09 s twice is not."""
    for progress, hopeless in ((0.11, [False, False, False]), (0.09, [False, True, True])):
        pace = Pace(start, start + 1.0, 100, 10)
        assert [pace.is_hopeless(start + k * progress, 10 * k) for k in (1, 2, 3)] == hopeless


def test_a_step_too_near_a_singular_pose_is_shortened_only_so_often():
    for avoided, stage_pivot, wanted in ((0, 1e-12, True), (0, 1.0, False), (explicit.PATIENT_AVOIDED, 1e-12, False)):
        assert explicit.is_too_near.py_func(1.0, stage_pivot, 1e-8, avoided, True) == wanted
    for adaptive in (True, False):
        assert explicit.is_too_near.py_func(1e-10, 1.0, 1e-8, explicit.PATIENT_AVOIDED, adaptive) == adaptive


@pytest.mark.parametrize(("natural", "taken"), [(3.0, 3.0), (0.0, 1.0)])
def test_away_from_a_singular_pose_steps_are_as_accuracy_allows_again(natural, taken):
    assert explicit.resumed.py_func(1.0, natural) == taken


@pytest.mark.parametrize(("evaluated", "verdict"), [(1, events.KEEP), (1, events.EVENT), (0, events.KEEP)])
def test_a_slope_is_evaluated_anew_where_something_may_have_moved_the_state(evaluated, verdict):
    known = evaluated == 1 and verdict != events.EVENT
    assert step.is_slope_known.py_func(SimpleNamespace(known=[1, evaluated]), verdict) == known


def test_two_estimates_make_one_error_as_in_dop853(monkeypatch):
    """DOP853's ERR^2 / sqrt(ERR^2 + 0.01 ERR2^2) (Hairer, Norsett, Wanner I, sec. II.10)."""
    monkeypatch.setattr(explicit, "_estimate", lambda model, work, weights, *given: weights[0])
    tableau = SimpleNamespace(error=np.array([3.0]), error_low=np.array([4.0]))
    found = explicit.error_norm.py_func(None, None, tableau, 0.1, None, None, False, 1.0, None, None)
    assert found == pytest.approx(9.0 / np.sqrt(9.0 + 0.01 * 16.0))


def test_roundoff_is_measured_by_the_largest_position(monkeypatch):
    monkeypatch.setattr(generalized_alpha, "position_count", lambda model: 3)
    for positions, size in (([0.1, -5.0, 2.0], 5.0), ([0.1, 0.2, 0.3], 1.0)):
        assert generalized_alpha._size.py_func(None, np.array([*positions, 90.0])) == size


@pytest.mark.parametrize(("room", "asked", "dense"), [(3, 1, True), (3, 0, False), (0, 1, False)])
def test_the_full_tangent_is_used_once_it_is_asked_for_where_there_is_room(room, asked, dense):
    tangent = SimpleNamespace(lu=np.empty((room, room)))
    assert generalized_alpha._is_dense.py_func(SimpleNamespace(needs_tangent=asked), tangent) == dense


def test_there_is_room_for_rates_and_multipliers_up_to_the_limit():
    limit = generalized_alpha.DENSE_LIMIT
    for n, m, room in ((limit - 5, 5, limit), (limit - 5, 6, 0)):
        rows = [("joint", slot, 0) for slot in range(m)]
        system = SimpleNamespace(rows=lambda every, rows=rows: rows)
        assert len(generalized_alpha._tangent(system, n).pivots) == room  # type: ignore[arg-type]


def at(h):
    """Return the ends of a step of size h of a state that is the time since its start."""
    return SimpleNamespace(y=[0.0], y_new=[h])


@pytest.mark.parametrize("start", [0.0, 1e6])
def test_an_event_is_located_as_closely_as_the_clock_tells_and_no_closer(monkeypatch, start):
    """The sine of 1 + 70 times the time since a step's start vanishes at (pi - 1) / 70 s."""

    def roots(model, work, t, y, duration, table):
        table[VALUE] = 1e16 * np.sin(1.0 + 70.0 * y[0])  # in its roundoff
        table[RATE] = 70e16 * np.cos(1.0 + 70.0 * y[0])

    def first_open(model, work, t, h, ends, run, low, new):
        return 1.0 if new[VALUE, 0] < 0.0 else 2.0

    monkeypatch.setattr(events, "roots", roots)
    monkeypatch.setattr(events, "first_open", first_open)
    for name in ("_open_bracket", "_tighten", "_propose", "_falls", "_keep"):
        monkeypatch.setattr(events, name, getattr(events, name).py_func)
    search, table, h, tries = np.zeros(8), events.Tables(*np.zeros((3, 4, 1))), 0.05, 1
    roots(None, None, start, [0.0], 0.0, table.low)
    while events.watch.py_func(None, None, start, h, at(h), None, search, table) == events.RETRY:
        h, tries = search[events.H_NEXT], tries + 1
    beyond = h - (np.pi - 1.0) / 70.0
    assert -1e-16 < beyond < 2.0 * events.ROUNDOFF * max(start, h)
    assert tries < 20
