"""A truth holds where its equations do, states an uncertainty that is computed, and raises nothing elsewhere."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from cross_checks import truths
from cross_checks.judge.runs import Runs
from cross_checks.truths import seek_truth, truth
from cross_checks.truths.made_by.numerics import closed_forms, rates
from cross_checks.truths.made_by.numerics.closed_forms import integral, rounding_error, running_integral
from cross_checks.truths.of.bouncing import impact
from cross_checks.truths.truth import EPS, NoConvergenceError, NoTruth, Truth, time_limit
from mbs_ref import scenes
from mbs_ref.scene.contact import HuntCrossleyLaw
from mbs_ref.scene.scales import Scales
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

H = 1e-5  # s, of central differences whose own error is some 1e-6 of the rates here


def truth_of(name, times, **parameters) -> Truth:
    found = seek_truth(scenes.make(name, **parameters), np.array(times))
    assert isinstance(found, Truth), found
    return found


def test_rates_on_a_driven_seat_are_the_slopes_of_its_positions():
    found = truth_of("android_simplified", [0.0, 0.01 - H, 0.01, 0.01 + H], model="paper", seat="driven")
    assert found.velocity is not None
    slope = (found.position[3] - found.position[1]) / (2.0 * H)
    np.testing.assert_allclose(found.velocity[2], slope, atol=1e-5)
    assert np.abs(slope[:, 0]).max() > 0.2  # m/s: the seat moves


@pytest.mark.parametrize("name", ["bouncing_ball", "bouncing_sphere"])
def test_velocities_at_an_impact_on_an_output_time_are_unknown_and_elsewhere_exact(name):
    found = truth_of(name, [0.0, 0.05, 0.1, 0.15, 0.2], law="rigid")  # it touches down at 0.1 s
    assert found.velocity is not None
    assert found.rate_uncertainty is not None
    assert np.isinf(found.rate_uncertainty).tolist() == [True, False, True, False, False]
    speeds = np.linalg.norm(found.velocity[:, 0], axis=1)
    np.testing.assert_allclose(speeds[[1, 3, 4]], [1.0, 0.5, 0.5], atol=1e-10)
    assert found.rate_uncertainty[[1, 3, 4]].max() < 1e-8


@pytest.mark.parametrize("jump", [0.0, 0.5, 1.0, 2.5, 5.0])
def test_no_place_of_a_jump_within_the_differences_gives_a_small_error_bar(jump):
    """The slope changes from -1 to 1; a central difference at the jump is 0 at every order."""
    times = np.array([0.0, 1.0])
    asked, h = rates.stencil_times(times, 1.0)
    place = np.zeros((len(asked), 1, 2))
    place[:, 0, 0] = np.abs(asked - 1.0 - jump * h)
    found = rates.of_poses(times, h, asked, (place, np.zeros((len(asked), 1))), 0.0, Scales(1.0, 1.0))
    assert np.isinf(found[2][1])


def test_a_quadrature_finds_a_peak_that_its_first_pieces_miss_and_bounds_its_error(monkeypatch):
    width = np.longdouble(1e-4)  # s: the integral of width / (width^2 + (t - 1/3)^2) is an arctangent
    times, middle = np.array([0.25, 0.5, 1.0], dtype=np.longdouble), 1 / np.longdouble(3)
    found, error = running_integral(lambda t: width / (width**2 + (t - middle) ** 2), times, 1.0)
    exact = np.arctan((times - middle) / width) + np.arctan(middle / width)
    assert np.abs(found - exact).max() < 1e-15
    assert error < 1e-14
    monkeypatch.setattr(closed_forms, "MOST_PIECES", 500)
    with pytest.raises(NoConvergenceError, match="t = "):
        running_integral(lambda t: np.sign(np.sin(1e6 * t)), times, 1.0, 0.0)
    with pytest.raises(NoConvergenceError, match="does not converge"):
        integral(lambda s: 1.0 / s, 0.0, 1.0)


def test_the_rounding_of_every_datum_counts():
    error = rounding_error(
        lambda data, t: data[0] * np.exp(data[1] * t), np.longdouble([1.0, 20.0]), np.array([0.0, 1.0])
    )
    assert error == pytest.approx(EPS * 21.0 * np.exp(20.0), rel=1e-6)


@pytest.mark.parametrize("parameters", [{"angle": 3.09}, {"speed": 0.05}])
def test_a_steep_spherical_pendulum_meets_the_solver(parameters):
    """The azimuth advances within a small part of the period: 0.5 m and 4e-6 m in fixed pieces."""
    scene = scenes.make("spherical_pendulum", **parameters)
    run = simulate(scene, Settings(rtol=1e-11, samples=11, estimate="off"))
    found = truth_of("spherical_pendulum", run.times, **parameters)
    assert found.uncertainty < 1e-11
    assert np.abs(found.position - run.position).max() < 1e-8


def test_near_the_separatrix_a_spherical_pendulum_is_not_known():
    found = truth_of("spherical_pendulum", [0.0, 10.0], angle=3.09, speed=0.05)
    assert found.uncertainty > 1e-12


@pytest.mark.parametrize(
    ("name", "parameters", "words"),
    [
        ("incline", {"angle": 1.4, "friction": 10.0}, "topples"),
        ("sliding_block", {"height": 1.5}, "topples"),
        ("colliding_spheres", {"law": "spring_damper", "obliquity": 0.0, "stiffness": 20.0}, "centres meet"),
        ("android_simplified", {"model": "paper", "law": "constraint"}, "seat_base"),
    ],
)
def test_outside_its_domain_a_truth_is_refused_with_the_reason(name, parameters, words):
    found = seek_truth(scenes.make(name, **parameters), np.linspace(0.0, 0.1, 4))
    assert isinstance(found, NoTruth)
    assert found.kind == "none"
    assert words in found.reason


def test_an_unexpected_exception_and_the_time_limit_are_reasons(monkeypatch):
    def broken(scene, times):
        raise ZeroDivisionError("a mistake")

    times = np.linspace(0.0, 0.7, 5)
    monkeypatch.setitem(truths._solvers(), "pendulum", broken)
    found = seek_truth(scenes.make("pendulum"), times)
    assert isinstance(found, NoTruth)
    assert found.kind == "defect"
    assert "ZeroDivisionError: a mistake" in found.reason
    monkeypatch.setattr(truths, "LIMIT_S", 0.0)
    late = seek_truth(scenes.make("double_pendulum"), times)
    assert isinstance(late, NoTruth)
    assert "processor time" in late.reason
    assert "t = 0 s" in late.reason
    assert late.limit_s == 0.0


def test_a_computation_that_cannot_end_in_time_is_given_up_early(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(truth.time, "thread_time", lambda: now[0])

    def at(spent, t):
        now[0] = 3.0 + spent
        pace.check(t)

    with time_limit(10.0):
        pace = truth.Pace(np.array([5.0, 6.0]))
        at(0.0, 5.0)  # the set-up
        at(0.9, 5.001)  # no tenth of the limit is spent
        at(2.0, 5.11)  # some 18 s are needed, and a motion may become easier
        with pytest.raises(NoConvergenceError, match=r"needs some 22 s of processor time, and its limit is 10 s"):
            at(2.0, 5.09)


def test_compilation_is_no_part_of_the_limit(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(truth.time, "thread_time", lambda: now[0])

    def slow() -> int:
        raise NotImplementedError

    @numba.extending.overload(slow)
    def typed():
        now[0] += 11.0
        return lambda: 1

    inner = numba.njit(lambda: slow())
    with time_limit(10.0):
        assert numba.njit(lambda: inner())() == 1
        assert now[0] >= 11.0
        truth.check_time(0.0)
        now[0] += 11.0
        with pytest.raises(NoConvergenceError, match="limit of processor time"):
            truth.check_time(0.0)


def test_what_a_limit_of_time_ended_is_computed_again_within_a_longer_one():
    scene, times, runs = scenes.make("double_pendulum", angle_1=0.37), np.linspace(0.0, 0.31, 3), Runs()
    with time_limit(0.0):
        late = [seek_truth(scene, times), runs.truth(scene, times), runs.truth(scene, times)]
    assert {getattr(one, "limit_s", None) for one in late} == {0.0}
    with time_limit(30.0):
        found = runs.truth(scene, times)
        assert isinstance(found, Truth)
        assert seek_truth(scene, times) == found
    with time_limit(0.0):
        assert isinstance(runs.truth(scene, times), Truth)
    refused = Runs()
    outside = scenes.make("incline", angle=1.4, friction=10.0)
    first = refused.truth(outside, times)
    assert isinstance(first, NoTruth)
    assert first.limit_s is None
    refused.call = None  # type: ignore[assignment]
    assert refused.truth(outside, times) == first


def test_the_restitution_of_a_slight_damping_is_known():
    """e = 1 - 2 D / 3 + O(D^2), D = c v / k."""
    found = impact(HuntCrossleyLaw(stiffness=1e6, damping=1e-3, exponent=1.5), 1.0, 1.0)
    assert 1.0 - found.restitution == pytest.approx(2e-9 / 3.0, rel=1e-6)
    elastic = impact(HuntCrossleyLaw(stiffness=1e6, damping=0.0, exponent=1.5), 1.0, 1.0)
    assert found.duration == pytest.approx(elastic.duration, rel=1e-8)


def test_the_restitution_of_a_strong_damping_is_known():
    """e D tends to 1 from below: the release is at the speed at which the force vanishes."""
    found = impact(HuntCrossleyLaw(stiffness=1e6, damping=1e8, exponent=1.5), 1.0, 1.0)
    assert found.restitution == pytest.approx(0.01, rel=1e-12)
    assert found.doubt == np.inf  # the duration is not known


def test_no_truth_is_better_known_than_its_coordinates_are_rounded():
    found = truth_of("incline", [0.0, 3e3], angle=0.5)
    assert found.uncertainty >= EPS * np.abs(found.position).max() > 1e-13
