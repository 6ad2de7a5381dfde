"""Parts of the figures of contacts, against motions in closed form at irregular times."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cross_checks.metrics import contact_figures as figures
from cross_checks.metrics.errors import reaction_error
from mbs_ref import scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import gap_of
from mbs_ref.trajectory import Trajectory

RNG = np.random.default_rng(12)
TIMES = np.cumsum(RNG.uniform(0.1, 0.3, 5))


@pytest.mark.parametrize("name", ["bouncing_ball", "bouncing_sphere"])
def test_a_flight_is_continued_with_constant_accelerations(name):
    """x = x0 + v t + a t^2/2 and w = w0 + b t about one axis, which the turn follows from either sample on."""
    scene = scenes.make(name)
    space = scene.dimension == 3
    x0, v, a = RNG.normal(size=(3, scene.dimension))
    axis = RNG.normal(size=3)
    axis /= np.linalg.norm(axis)
    w, b = RNG.normal(size=2)

    def motion(t: np.ndarray) -> Trajectory:
        place, rate = x0 + np.outer(t, v) + 0.5 * np.outer(t**2, a), v + np.outer(t, a)
        turn, spin = w * t + 0.5 * b * t**2, w + b * t
        orientation = Rotation.from_rotvec(np.outer(turn, axis)).as_quat(scalar_first=True) if space else turn
        return Trajectory(t, place[:, None], orientation[:, None], rate[:, None],
                          (np.outer(spin, axis) if space else spin)[:, None])  # fmt: skip

    wanted = np.array([0.17, 1.9, 2.3])
    found = figures._continued(Motion(scene, motion(TIMES)), (1, 3), 3, wanted).trajectory
    expected = motion(wanted)
    assert found.position == pytest.approx(expected.position)
    assert found.velocity == pytest.approx(expected.velocity)
    assert found.angular_velocity == pytest.approx(expected.angular_velocity)
    if not space:
        assert found.orientation == pytest.approx(expected.orientation)
    else:
        turns = Rotation.from_quat(found.orientation[:, 0], scalar_first=True).inv() * Rotation.from_quat(
            expected.orientation[:, 0], scalar_first=True
        )
        assert np.abs(turns.as_rotvec()).max() < 1e-12


@pytest.mark.parametrize(("ways", "creeps"), [((3.0, 3.1), True), ((3.0, 2.9), True), ((3.0, 2.0), False),
                                              ((2.0, 3.0), False)])  # fmt: skip
def test_a_body_creeps_where_the_last_quarters_are_as_fast(ways, creeps):
    scene = scenes.make("bouncing_ball")
    times = np.linspace(0.0, 4.0, 9)
    x = np.interp(times, (0.0, 2.0, 3.0, 4.0), np.cumsum((0.0, 9.0, *ways)))
    place = np.stack((0.6 * x, 0.8 * x), axis=1)[:, None]
    path = Trajectory(times, place, np.zeros((9, 1)), np.zeros_like(place), np.zeros((9, 1)))
    found = figures._creep(Motion(scene, path), scene.contacts[0])
    assert found == (pytest.approx({"creep, m/s": sum(ways) / 2.0}) if creeps else {})


def test_contacts_closed_from_the_start_have_figures_and_those_that_never_touch_have_none():
    scene = scenes.make("sliding_block")
    path: Any = Trajectory(TIMES, *(np.zeros((5, 1, *shape)) for shape in ((2,), (), (2,), ())))
    path.position[:, 0, 1] = np.array([-0.2, -0.1, -0.4, -0.3, -0.2]) * 1e-3
    for event_times, names in ((None, ()), (np.zeros((0, 2)), ())):
        found = figures.contact_figures(scene, replace(path, event_times=event_times, event_names=names))
        assert found[f"{scene.contacts[0].name}: penetration, m"] == pytest.approx(
            4e-4 - _height(scene, scene.contacts[0]), rel=0.2
        )
    path.position[:, 0, 1] = 1.0
    assert figures.contact_figures(scene, replace(path, event_times=np.zeros((0, 2)), event_names=())) == {}
    many = scene.model_copy(update={"contacts": scene.contacts[:1] * (figures.MANY + 1)})
    path.position[:, 0, 1] = -1e-3
    assert figures.contact_figures(many, path) == {}
    assert figures.contact_figures(many.model_copy(update={"contacts": scene.contacts[:1]}), path)


def _height(scene: Any, contact: Any) -> float:
    """Return how far a corner lies above the centre of its block, both as drawn (m)."""
    return contact.center[1] - scene.bodies[0].position[1]


def test_a_flight_is_continued_from_the_sample_beside_the_surface():
    """Its accelerations are those between two samples, its place and speed those of the nearer one."""
    scene = scenes.make("bouncing_ball")
    times = 0.1 * np.arange(6.0)
    gap, v = np.array([0.35, 0.22, 0.05, -0.1, 0.05, 0.22]), np.array([-1.0, -1.2, -2.0, 0.1, 2.0, 1.2])
    rate, still = np.stack((np.zeros(6), v), axis=1)[:, None], np.zeros((6, 1))
    path, contact = Trajectory(times, np.zeros((6, 1, 2)), still, rate, still), scene.contacts[0]
    path.position[:, 0, 1] = gap - gap_of(Motion(scene, path), contact)[0]
    for pair, near, ahead in (((1, 2), 2, 1.0), ((4, 5), 4, -1.0)):
        a = float(np.diff(v[list(pair)])[0] / 0.1)
        (after,) = (t for t in np.roots([0.5 * a, v[near], gap[near]]) if 0.0 < ahead * t < 0.1)
        found = figures._at_surface(Motion(scene, path), contact, pair, 3)
        assert found is not None
        assert found[:2] == pytest.approx((v[near] + a * after, times[near] + after))
    low = replace(path, position=path.position - np.array([0.0, 1.0]))
    assert figures._at_surface(Motion(scene, low), contact, (1, 2), 3) is None  # it begins inside


def test_torques_of_joints_in_space_count():
    one = {"pin": RNG.normal(size=(4, 6))}
    for column in range(6):
        other = {"pin": one["pin"].copy()}
        other["pin"][2, column] += 7.0
        assert reaction_error(one, other) == pytest.approx(7.0)


def test_an_impulse_is_stated_of_free_bodies_alone():
    """The reduced mass of two bodies, the mass of one against the ground; none where anything else acts."""
    scene = scenes.make("colliding_spheres")
    free = scene.model_copy(update={"gravity": (0.0,) * scene.dimension, "loads": (), "joints": ()})
    (contact,) = free.contacts
    path: Any = None
    masses = [free.bodies[free.body_index(name)].mass for name in (contact.body_a, contact.body_b)]
    found = figures._free_mass(Motion(free, path), contact)
    assert found in (None, pytest.approx(1.0 / sum(1.0 / mass for mass in masses)))
    ball = scenes.make("bouncing_ball")
    alone = ball.model_copy(update={"gravity": (0.0, 0.0), "loads": (), "joints": ()})
    touch = alone.contacts[0].model_copy(update={"friction": None})
    alone = alone.model_copy(update={"contacts": (touch,)})
    assert figures._free_mass(Motion(alone, path), touch) == pytest.approx(alone.bodies[0].mass)
    spring = scenes.make("spring_pendulum").loads[:1]
    rod = scenes.make("pendulum").joints[:1]
    assert len(spring) == len(rod) == 1
    for more in ({"gravity": (0.0, -9.81)}, {"gravity": (1e-3, 0.0)}, {"loads": spring}, {"joints": rod},
                 {"contacts": (touch, touch)}):  # fmt: skip
        assert figures._free_mass(Motion(alone.model_copy(update=more), path), touch) is None
