"""Converged truths: verified by the judge's energy and by means their makers do not use; refused where unsound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cross_checks import truths
from cross_checks.truths import _solved, known, seek_truth, truth_for
from cross_checks.truths.made_by import Formulation, agree
from cross_checks.truths.made_by.mechanisms.rod_chain import solve
from cross_checks.truths.made_by.numerics.solvers import extrapolate
from cross_checks.truths.made_by.numerics.tabulated import POINTS, Tabulated
from cross_checks.truths.truth import NoConvergenceError, NoTruth, Truth
from mbs_ref import observables as judge
from mbs_ref import scenes
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

SPACING = 1e-3  # s, of the samples that velocities are differenced from
MOMENTS = 3  # at which a truth is judged: the motion's whole span, without a step onto every millisecond


def moving(scene: Scene, moments: np.ndarray) -> Trajectory:
    """A truth as a trajectory at moments counted in SPACING, its velocities by differences of order 8."""
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]) / SPACING
    window = moments[:, None] + np.arange(-4, 5)
    wanted, place = np.unique(window, return_inverse=True)
    place = place.reshape(window.shape)
    truth = truth_for(scene, wanted * SPACING)
    assert truth is not None
    angle = truth.orientation if scene.dimension == 2 else continuous(truth.orientation)
    velocity, spin = (np.einsum("w,nw...->n...", weights, q[place]) for q in (truth.position, angle))
    middle = place[:, 4]
    if scene.dimension == 3:
        spin = turning(angle[middle], spin)
    return Trajectory(moments * SPACING, truth.position[middle], angle[middle], velocity, spin)


def continuous(theta: np.ndarray) -> np.ndarray:
    """Euler parameters (n_t, n_bodies, 4) without jumps of sign."""
    signs = np.where(np.sum(theta[1:] * theta[:-1], axis=2) < 0.0, -1.0, 1.0)
    return theta * np.concatenate((np.ones((1, theta.shape[1])), np.cumprod(signs, axis=0)))[:, :, None]


def turning(theta: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """omega = 2 E theta', world axes."""
    e0, e, d0, d = theta[..., :1], theta[..., 1:], rate[..., :1], rate[..., 1:]
    return 2.0 * (e0 * d - d0 * e + np.cross(e, d))


# judged in test_against_de440.py, test_sky_truths.py, test_gravity_gradient.py and test_nesc_files.py: no joints
IN_THE_SKY = {
    "figure_eight", "kepler", "librating_satellite", "nesc_dropped_sphere", "nesc_sphere_in_air",
    "outer_solar_system", "pleiades", "satellite", "solar_system",
}  # fmt: skip

# the energy is not kept: judged in test_android_truths.py, test_spatial_truths.py and test_suspension_rig.py
DAMPED = {"android_simplified", "android_spatial", "android_vertebral", "flyball_governor", "suspension_rig"}
SMALLER = {  # quicker to solve, or slow enough to be differenced
    "pendulum_chain": {"links": 3},
    "spatial_chain": {"links": 3},
    "double_gyroscope": {"spin": 20.0, "second_spin": -10.0},
}
SLOW = {  # to solve
    "bricard", "cardan_joint", "double_gyroscope", "four_bar_with_spring", "spatial_chain", "spatial_slider_crank",
}  # fmt: skip

IN_CONTACT = {  # judged in test_contact_truths.py and test_spatial_contact.py: speeds jump, energy is lost
    "ball_on_driven_seat", "bouncing_ball", "box_stack", "disc_between_walls", "incline", "newtons_cradle",
    "oblique_disc", "rolling_disc", "sliding_block", "bouncing_sphere", "rolling_sphere", "colliding_spheres",
    "block_stack", "ball_on_moving_seat",
}  # fmt: skip


# driven or published: judged below, in test_linkages.py and in test_published_problems.py
ELSEWHERE = {"driven_pendulum", "straight_line_linkage", "puma560", "stanford_arm", "andrews", "car_axis"}


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name
    for name in sorted(set(known()) - ELSEWHERE - IN_CONTACT - IN_THE_SKY - DAMPED)
])  # fmt: skip
def test_every_truth_obeys_the_joints_and_keeps_the_energy(name):
    scene = scenes.make(name, **SMALLER.get(name, {}))
    path = moving(scene, np.linspace(4, 96 if name in SLOW else 496, MOMENTS).round().astype(int))
    differencing = 1e-10  # 1e-16 / SPACING, magnified by masses and speeds
    assert np.max(np.abs(judge.constraint_residual(scene, path)), initial=0.0) < 1e-14
    assert np.max(np.abs(judge.constraint_rate(scene, path)), initial=0.0) < differencing
    energy = judge.kinetic_energy(scene, path) + judge.potential_energy(scene, path)
    assert np.ptp(energy) < 1e-9  # J, of some ten


def test_the_driven_pendulum_obeys_its_drive_and_newton_on_the_carriage():
    """The rod's equation by a third means: d/dt of its angular momentum about the pivot, in the carriage's frame."""
    scene = scenes.make("driven_pendulum")
    path = moving(scene, np.arange(4, 997))
    assert np.max(np.abs(judge.constraint_residual(scene, path))) < 1e-14
    theta, spin, t = path.orientation[:, 1], path.angular_velocity[:, 1], path.times
    torque = -0.5 * np.cos(theta) * 9.81 - 0.5 * np.sin(theta) * 0.2 * 25.0 * np.cos(5.0 * t)  # N m
    gained = np.concatenate([[0.0], np.cumsum((torque[1:] + torque[:-1]) / 2) * SPACING])
    trapezoidal = 1e-5
    np.testing.assert_allclose((spin - spin[0]) / 3.0, gained, atol=trapezoidal)


def test_double_pendulum_against_the_textbook_pair_of_equations():
    """Two rods, mass matrix inverted by hand, by SciPy's Radau."""
    l1, l2, m1, m2, g = 1.0, 0.8, 1.0, 0.6, 9.81

    def derivative(t, y):
        a, b, u, v = y
        m11, m22, m12 = l1**2 * (m1 / 3 + m2), m2 * l2**2 / 3, m2 * l1 * l2 / 2 * np.cos(a - b)
        s = m2 * l1 * l2 / 2 * np.sin(a - b)
        f1 = -s * v**2 - g * l1 * (m1 / 2 + m2) * np.cos(a)
        f2 = s * u**2 - g * l2 * m2 / 2 * np.cos(b)
        det = m11 * m22 - m12**2
        return [u, v, (m22 * f1 - m12 * f2) / det, (m11 * f2 - m12 * f1) / det]

    end = solve_ivp(derivative, (0.0, 1.0), [0.0, 0.5, 0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-12).y[:2, -1]
    truth = truth_for(scenes.make("double_pendulum"), np.array([0.0, 1.0]))
    assert truth is not None
    np.testing.assert_allclose(truth.orientation[-1], end, atol=1e-8)


def test_one_link_swings_as_a_compound_pendulum():
    """Period of a rod released horizontally: 4 K(1/2) sqrt(2 l / (3 g))."""
    period = 4 * 1.8540746773013719 * np.sqrt(2.0 / 3.0 / 9.81)  # K(1/2), Abramowitz & Stegun table 17.1
    truth = truth_for(scenes.make("pendulum_chain", links=1), np.array([period / 2, period]))
    assert truth is not None
    np.testing.assert_allclose(truth.position[:, 0], [[-0.5, 0.0], [0.5, 0.0]], atol=1e-14)


def test_a_truth_is_refused_with_a_reason():
    times = np.linspace(0.0, 1.0, 3)
    long = seek_truth(scenes.make("pendulum_chain", links=1000), times)
    changed = scenes.make("pendulum").model_copy(update={"gravity": (0.0, -1.0)})
    stranger = scenes.make("pendulum").model_copy(update={"name": "stranger"})
    for word, found in {"1000": long, "physics": seek_truth(changed, times)}.items():
        assert isinstance(found, NoTruth)
        assert word in found.reason
    assert truth_for(changed, times) is None
    assert truth_for(stranger, times) is not None  # a truth belongs to physics, not to a name


@pytest.mark.slow
def test_a_chaotic_motion_has_no_truth_at_its_end():
    found = seek_truth(scenes.make("double_pendulum", angle_1=2.0, angle_2=2.5), np.array([0.0, 20.0]))
    assert isinstance(found, NoTruth)
    assert "sensitive" in found.reason


@pytest.mark.parametrize("uncertainty", [1e-9, 2e-8, np.nan])
def test_a_truth_that_is_not_known_to_1e_8_of_the_scene_is_none(uncertainty, monkeypatch):
    times = np.array([0.0, 0.123])
    exact = truth_for(scenes.make("pendulum"), times)
    assert exact is not None
    _solved.cache_clear()
    doubtful = replace(exact, uncertainty=uncertainty)
    monkeypatch.setattr(truths, "_solvers", lambda: {"pendulum": lambda scene, times: doubtful})
    found = seek_truth(scenes.make("pendulum"), times)
    _solved.cache_clear()
    assert isinstance(found, Truth) == (uncertainty == 1e-9)
    assert isinstance(found, Truth) or "sensitive" in found.reason


def test_disagreement_becomes_uncertainty():
    def decay(rate):
        return Formulation(lambda t, y: -rate * y, np.array([1.0]), lambda t, y: (np.array([[y[0], 0.0]]), np.zeros(1)))

    same = agree(decay(1.0), decay(1.0), np.array([0.0, 1.0]), ("one", "other"), extended=True)
    other = agree(decay(1.0), decay(1.0 + 1e-6), np.array([0.0, 1.0]), ("one", "other"), extended=True)
    assert same.uncertainty < 1e-14
    assert other.uncertainty == pytest.approx(1e-6 * np.exp(-1.0), rel=1e-3)


def test_extrapolation_reaches_extended_precision_and_says_where_it_stalls():
    one = np.array([1.0], dtype=np.longdouble)
    end = extrapolate(lambda t, y: -y, one, np.array([0.0, 1.0]), 64 * float(np.finfo(np.longdouble).eps))[-1, 0]
    assert abs(end - np.exp(np.longdouble(-1))) < 1e3 * np.finfo(np.longdouble).eps
    with np.errstate(all="ignore"), pytest.raises(NoConvergenceError, match="t = "):
        extrapolate(lambda t, y: y**2, np.array([1.0]), np.array([0.0, 2.0]), 1e-14)  # infinite at t = 1


@pytest.mark.parametrize("kind", [float, np.longdouble])
def test_the_elimination_solves(kind):
    rng = np.random.default_rng(3)
    root, x = rng.normal(size=(7, 7)), rng.normal(size=7)
    matrix = (root @ root.T + np.eye(7)).astype(kind)
    np.testing.assert_allclose(solve(matrix, matrix @ x.astype(kind)).astype(float), x, rtol=1e-11)


def test_interpolated_functions_are_those_functions_in_extended_precision():
    """1 / (1 + 25 s^2) has poles near the axis: its pieces are halved; a constant has no derivative to resolve."""

    def function(s):
        square = 1 + 25 * s * s
        return np.array([1 / square, -50 * s / square**2, 3 + 0 * s, 1e-19 * np.sin(1e3 * s)])

    tabulated = Tabulated(function)
    for s in np.random.default_rng(3).uniform(-2.0, 2.0, 200).astype(np.longdouble):
        np.testing.assert_allclose((tabulated(s) - function(s)).astype(float)[:3], 0.0, atol=1e-17)
    assert len({width for width, _ in tabulated.pieces}) > 1
    width, number = next(key for key, values in tabulated.pieces.items() if values is not None)
    node = (number + (POINTS[3] + 1) / 2) * width
    np.testing.assert_allclose((tabulated(node) - function(node)).astype(float)[:3], 0.0, atol=1e-17)


def test_a_function_that_is_not_smooth_is_not_interpolated():
    with pytest.raises(NoConvergenceError, match="not smooth near 0"):
        Tabulated(lambda s: np.array([np.abs(s - 0.1), 0 * s]))(np.longdouble(0.1))


def test_extrapolation_takes_short_steps_where_they_are_needed_alone():
    """A Kepler orbit of eccentricity 0.9 returns to its start; near its focus a step is a hundredth of the longest."""
    calls = []

    def derivative(t, y):
        calls.append(float(t))
        return np.concatenate((y[2:], -y[:2] / (y[0] ** 2 + y[1] ** 2) ** np.longdouble(1.5)))

    start = np.array([0.1, 0.0, 0.0, 19.0**0.5], dtype=np.longdouble)
    start[3] = np.sqrt(2 / start[0] - 1)
    period = 8 * np.arctan(np.longdouble(1))
    end = extrapolate(derivative, start, np.array([0.0, period], dtype=np.longdouble), 1e-16)[-1]
    assert float(np.abs(end - start)[:2].max()) < 1e-13
    assert len(calls) < 4000  # 4869 where steps are only halved and doubled
