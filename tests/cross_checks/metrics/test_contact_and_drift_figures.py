"""Compliance, depth, impulse and creep of made-up motions whose figures are known, worst neither first nor last."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cross_checks.ephemerides import Observed
from cross_checks.metrics.contact_figures import _deepest, contact_figures
from cross_checks.metrics.drifts import METRICS, compliance, energy_drift
from cross_checks.metrics.errors import reaction_error, significant_figures
from cross_checks.metrics.metric import Absent, Judged, known_to, largest_value
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from mbs_ref.observables.energy import EnergyBalance
from mbs_ref.scene import PlanarBody, PointMass, Scene
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, RegularisedCoulomb, SpringDamperLaw
from mbs_ref.scene.scales import scales_of
from mbs_ref.trajectory import Trajectory

LAW = SpringDamperLaw(stiffness=1e4)


def sliding(times: np.ndarray, place: np.ndarray, speed: np.ndarray) -> Trajectory:
    """Return bodies that move without turning; places and speeds (n_t, n_bodies, 2)."""
    still = np.zeros(place.shape[:2])
    return Trajectory(times, place, still, speed, still)


def test_compliance_is_that_of_the_worst_joint_at_each_sample():
    """The rods of 1.1 and 0.7 m are torn apart by known gaps."""
    scene = scenes.make("double_pendulum", length_1=1.1, length_2=0.7)
    places = np.array([[body.position for body in scene.bodies]] * 3)
    angles = np.array([[body.angle for body in scene.bodies]] * 3)
    places[1] += (0.0, 0.03)  # both rods: the first joint opens
    places[2, 1] += (0.02, 0.0)  # the second alone
    still = np.zeros((3, 2))
    path = Trajectory(np.array([0.0, 1.0, 2.0]), places, angles, np.zeros_like(places), still)
    assert compliance(scene, path)[0] == pytest.approx([0.0, 0.03, 0.02], abs=1e-12)
    position = next(metric for metric in METRICS if metric.name == "compliance_position")
    steps = np.array([[0.0, 0.0], [0.7, 0.01], [1.7, 0.05]])  # time and the largest over the steps before
    judged = Judged(scene, replace(path, step_compliance=steps), NoTruth(""))
    assert position.curve(judged) == pytest.approx([0.0, 0.03, 0.05], abs=1e-12)


def test_the_largest_value_is_no_other():
    assert largest_value(np.array([1.0, 7.0, 3.0])) == 7.0


@pytest.mark.parametrize(("resolution", "known"), [(0.05, True), (0.2, False)])
def test_a_drift_is_stated_where_the_work_is_known_to_a_tenth_of_it(monkeypatch, resolution, known):
    balance = EnergyBalance(np.array([2.0, 2.0]), None, np.array([-1.0, 0.5]), resolution)
    monkeypatch.setattr("cross_checks.metrics.drifts.energy_drift", energy_drift)
    monkeypatch.setattr("cross_checks.metrics.drifts.energy_balance", lambda scene, run: balance)
    drift = energy_drift(None, None)  # type: ignore[arg-type]
    assert isinstance(drift, Absent) != known
    assert isinstance(drift, Absent) or drift.tolist() == [1.0, 0.5]


def test_reactions_differ_by_the_largest_at_any_sample():
    other = np.zeros((5, 3))
    other[2, 1] = -4.0
    assert reaction_error({"a": np.zeros((5, 3))}, {"a": other}) == 4.0


def test_depth_between_samples():
    """A gap of (t - 1)^2 - 0.5, seen at six times, none of them 1 s."""
    floor = CircleOnLine(name="floor", body_a="ball", center=(0.0, 3.0), radius=0.5, point_1=(0.0, 0.0),
                         point_2=(1.0, 0.0), law=LAW)  # fmt: skip
    ball = PlanarBody(name="ball", mass=2.0, inertia=1.0, position=(0.0, 3.0))
    scene = Scene(name="ball", bodies=(ball,), contacts=(floor,), gravity=(0.0, -9.0), duration=2.2)
    times = np.array([0.0, 0.2, 0.7, 1.15, 1.9, 2.2])
    place = np.stack((0.0 * times, (times - 1.0) ** 2), 1)[:, None]
    speed = np.stack((0.0 * times, 2.0 * (times - 1.0)), 1)[:, None]
    assert contact_figures(scene, sliding(times, place, speed))["floor: penetration, m"] == pytest.approx(0.5, rel=1e-3)


def test_the_impulse_of_two_free_balls():
    """Balls of 2 and 3 kg meet at 5 m/s and part at 2 m/s: 1.2 kg times 7 m/s."""
    balls = tuple(PlanarBody(name=name, mass=mass, inertia=1.0, position=place)
                  for name, mass, place in (("a", 2.0, (0.0, 0.0)), ("b", 3.0, (2.0, 0.0))))  # fmt: skip
    touch = CircleOnCircle(name="touch", body_a="a", center_a=(0.0, 0.0), radius_a=0.5, body_b="b",
                           center_b=(2.0, 0.0), radius_b=0.25, law=LAW)  # fmt: skip
    scene = Scene(name="two", bodies=balls, contacts=(touch,), gravity=(0.0, 0.0), duration=1.0)
    times, meet = np.linspace(0.0, 1.0, 8), 0.25
    gap = np.where(times < meet, 5.0 * (meet - times), 2.0 * (times - meet))
    rate = np.where(times < meet, -5.0, 2.0)
    place, speed = np.zeros((8, 2, 2)), np.zeros((8, 2, 2))
    place[:, 0, 0], place[:, 1, 0] = -0.6 * gap, 0.75 + 0.4 * gap
    speed[:, 0, 0], speed[:, 1, 0] = -0.6 * rate, 0.4 * rate
    figures = contact_figures(scene, sliding(times, place, speed))
    assert figures["touch: impulse, N s"] == pytest.approx(8.4)
    assert figures["touch: restitution"] == pytest.approx(0.4)


def test_creep_is_the_way_over_the_last_half_by_its_time():
    """Quarters of unequal length with speeds 1.0 and 1.05 mm/s."""
    block = PlanarBody(name="block", mass=2.0, inertia=1.0, position=(0.0, -0.001))
    grip = RegularisedCoulomb(coefficient=0.5, speed=0.1)
    foot = CircleOnLine(name="foot", body_a="block", center=(0.0, -0.001), radius=0.0, point_1=(0.0, 0.0),
                        point_2=(1.0, 0.0), law=LAW, friction=grip)  # fmt: skip
    scene = Scene(name="block", bodies=(block,), contacts=(foot,), gravity=(0.0, -9.0), duration=8.0)
    times = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 8.0])  # the last half: 4 s, 7 s, 8 s
    way = np.interp(times, (0.0, 4.0, 7.0, 8.0), (0.0, 4e-3, 7e-3, 8.05e-3))
    place = np.stack((way, np.full(8, -0.001)), 1)[:, None]
    figures = contact_figures(scene, sliding(times, place, np.zeros((8, 1, 2))))
    assert figures["foot: creep, m/s"] == pytest.approx(4.05e-3 / 4.0)


def test_figures_of_a_moon_count_from_its_planet():
    names = ("sun", "earth", "moon")
    scene = Scene(name="sky", duration=1.0, gravity=(0.0, 0.0, 0.0), bodies=tuple(
        PointMass(name=name, mass=1.0, position=(float(k), 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
        for k, name in enumerate(names)))  # fmt: skip
    true = np.array([[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [1010.0, 0.0, 0.0]])
    off = true + np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.1, 0.0, 0.0]])
    path = Trajectory(np.array([0.0]), off[None], np.zeros((1, 3, 4)), np.zeros((1, 3, 3)), np.zeros((1, 3, 3)))
    observed = Observed(true, "made up")
    assert significant_figures(scene, path, observed) == pytest.approx({"earth": 3.0, "moon": 2.0})


def test_turns_of_particles_are_known_over_the_scenes_length():
    bodies = tuple(PointMass(name=name, mass=1.0, position=place, velocity=(0.0, 0.0))
                   for name, place in (("a", (0.0, 0.0)), ("b", (0.0, 40.0))))  # fmt: skip
    scene = Scene(name="dots", bodies=bodies, gravity=(0.0, 0.0), duration=1.0)
    truth = Truth(np.zeros((1, 2, 2)), np.zeros((1, 2)), 1e-6, "exact", "")
    assert known_to(scene, truth) == pytest.approx(1e-6 / scales_of(scene).length)


@pytest.mark.parametrize("seed", range(3))
def test_a_depth_at_one_sample_alone_is_that_samples(seed):
    rng = np.random.default_rng(seed)
    gap = rng.uniform(0.1, 1.0, 7)
    gap[2] = -0.3
    assert _deepest(np.sort(rng.uniform(0.0, 1.0, 7)), gap, rng.normal(size=7)) == 0.3


def passing(places: np.ndarray, times: np.ndarray) -> dict[str, float]:
    """Return the figures of ball a at `places` (n_t, 2) and ball b at (2 m, 0) at first, then in the origin."""
    bodies = tuple(PlanarBody(name=name, mass=2.0, inertia=1.0, position=place)
                   for name, place in (("a", (0.0, 0.0)), ("b", (2.0, 0.0))))  # fmt: skip
    touch = CircleOnCircle(name="touch", body_a="a", center_a=(0.0, 0.0), radius_a=0.5, body_b="b",
                           center_b=(2.0, 0.0), radius_b=0.25, law=LAW)  # fmt: skip
    scene = Scene(name="two", bodies=bodies, contacts=(touch,), gravity=(0.0, 0.0), duration=1.0)
    place = np.stack((places, np.zeros_like(places)), axis=1)
    return contact_figures(scene, sliding(times, place, np.gradient(place, times, axis=0)))


def test_balls_that_pass_through_each_other_have_no_restitution():
    """They part on the other side, wherever their centres were at the start; an unknown place has no depth."""
    times = np.linspace(0.0, 1.0, 12)
    places = np.stack((-2.0 + 4.0 * times, 0.1 + 0.0 * times), axis=1)
    assert list(passing(places, times)) == ["touch: penetration, m"]
    places[5] = np.nan
    assert passing(places, times) == {}
