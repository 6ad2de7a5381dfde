"""Linkages with closed forms: a straight line, two nearly straight ones, and the speeds of Cardan's joint."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from cross_checks.judge.one_run import evaluate
from mbs_ref import scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.simulate.linearised import steady_motion_at_start

FINE = Settings(rtol=1e-11, samples=21, estimate="off")


def path_of(kind: str, rod: str, share: float) -> np.ndarray:
    """Return where (n_t, 2), m, the point of a rod is that lies at a share of its length."""
    scene = scenes.make("straight_line_linkage", kind=kind)
    path = simulate(scene, FINE)
    assert path.ok, path.message
    marks = {joint.name.partition(".")[0]: joint.point for joint in scene.joints if "point" in vars(joint)}
    one, other = (np.array(marks[pin]) for pin in rod)
    return Motion(scene, path).point(rod, tuple((1.0 - share) * one + share * other))[0]


def test_peaucelliers_pin_stays_on_its_line():
    """The inverse of a circle through the pole, at (R^2 - r^2) / (2 a) with a crank of a = 1 m."""
    drawn = path_of("peaucellier", "AQ", 1.0)
    assert drawn[:, 0] == pytest.approx((2.5**2 - 1.0) / 2.0, abs=1e-12)
    assert np.ptp(drawn[:, 1]) > 0.5  # m


@pytest.mark.parametrize(("kind", "along", "bound"), [("watt", 1, 5e-3), ("chebyshev", 0, 5e-3)])
def test_the_middle_of_the_coupler_nearly_draws_a_line(kind, along, bound):
    drawn = path_of(kind, "BC", 0.5)
    off = np.polynomial.Polynomial.fit(drawn[:, along], drawn[:, 1 - along], 1)
    assert np.abs(off(drawn[:, along]) - drawn[:, 1 - along]).max() < bound * np.ptp(drawn[:, along])


@pytest.mark.parametrize("angle", [30.0, 70.0])
def test_cardans_shafts_turn_at_the_ratio_of_their_angles(angle):
    """w2 / w1 = cos b / (1 - sin^2 b sin^2 phi), phi the turn of the first shaft."""
    path = simulate(scenes.make("cardan_joint", angle=angle), FINE)
    assert path.ok, path.message
    first, second = (np.linalg.norm(path.angular_velocity[:, k], axis=1) for k in (0, 1))
    phi = 2.0 * np.arctan2(path.orientation[:, 0, 1], path.orientation[:, 0, 0])
    bend = np.radians(angle)
    assert second / first == pytest.approx(np.cos(bend) / (1.0 - (np.sin(bend) * np.sin(phi)) ** 2), abs=1e-10)


def test_a_four_bar_on_its_spring_rests_and_swings_as_its_potential_says():
    """V = 2 m g sin(theta) + k (s - s0)^2 / 2 with s = 2 sin(theta/2), T = 5/6 m theta'^2, sides of 1 m."""
    stiffness, rest, weight = 400.0, 1.2, 2.0 * 9.81
    scene = scenes.make("four_bar_with_spring", stiffness=stiffness, rest=rest, start="equilibrium")

    def slope(theta: float) -> float:
        return weight * np.cos(theta) + stiffness * (2.0 * np.sin(0.5 * theta) - rest) * np.cos(0.5 * theta)

    theta: Any = brentq(slope, 0.5, 2.5, xtol=1e-15)
    crank: Any = scene.bodies[0]
    assert crank.angle == pytest.approx(theta, abs=1e-12)
    curvature = stiffness * (np.cos(0.5 * theta) ** 2 - (np.sin(0.5 * theta) - 0.5 * rest) * np.sin(0.5 * theta))
    omega = np.sqrt((curvature - weight * np.sin(theta)) / (5.0 / 3.0))
    assert np.abs(steady_motion_at_start(scene).eigenvalues.imag).max() == pytest.approx(omega, rel=1e-8)


def test_a_four_bar_whose_spring_would_fold_it_is_refused():
    with pytest.raises(ValueError, match="let the spring's ends meet: its rest length must be larger"):
        scenes.make("four_bar_with_spring", rest=0.002)
    assert scenes.make("four_bar_with_spring", angle=30.0, rest=1.998).bodies


@pytest.mark.parametrize("kind", ["peaucellier", "watt", "chebyshev"])
def test_rods_are_where_their_closed_form_has_them(kind):
    record = evaluate(scenes.make("straight_line_linkage", kind=kind), "mbs_ref", FINE)
    assert record.error is not None
    assert record.error.value < 1e-10
