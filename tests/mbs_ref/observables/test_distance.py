"""Distances against computations of a few lines on irregular random motions, and how far a motion goes."""

from __future__ import annotations

import math
from itertools import product as every
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbs_ref.cores.system import Poses
from mbs_ref.observables.distance import (
    Partial,
    coordinate_size,
    distances,
    farthest,
    motion_size,
    point_distances,
    relative,
    units_of,
)
from mbs_ref.scene import PlanarBody, PointMass, Scene, SpatialBody
from mbs_ref.scene.scales import Scales, scales_of

ROD = Scene(name="rod", bodies=(PlanarBody(name="rod", mass=4.0, inertia=1.0),))
TOP = Scene(
    name="top",
    gravity=(0.0, 0.0, 0.0),
    bodies=(SpatialBody(name="top", mass=1.0, inertia=(0.03, 0.03, 0.04, 0.0, 0.0, 0.0)),),
)
DOT = Scene(name="dot", bodies=(PointMass(name="dot", mass=1.0, position=(0.0, 0.0), velocity=(0.0, 0.0)),))
SCALES = Scales(length=2.0, time=0.5)
N_T = 7


def mixed(dimension: int) -> Scene:
    """Return a scene of a particle, then a large body; its length is not 1 m."""
    zero = (0.0,) * dimension
    dot = PointMass(name="dot", mass=1.0, position=zero, velocity=zero)
    rod = PlanarBody(name="last", mass=2.0, inertia=6.0, position=(7.0, 0.0)) if dimension == 2 else SpatialBody(
        name="last", mass=2.0, inertia=(6.0, 7.0, 8.0, 0.0, 0.0, 0.0), position=(7.0, 0.0, 0.0))  # fmt: skip
    return Scene(name="mixed", bodies=(dot, rod), gravity=(0.0,) * dimension, duration=3.0)


def irregular(dimension: int, seed: int, n: int = N_T) -> Poses:
    """Return a random motion of two bodies of which the last is farthest off at the first sample."""
    random = np.random.default_rng(seed)
    size = np.ones((n, 2))
    size[0, 1] = 50.0
    turn = (n, 2) if dimension == 2 else (n, 2, 3)
    vectors = [random.standard_normal((n, 2, dimension)) * size[..., None] for _ in range(2)]
    spin = random.standard_normal(turn)
    angle = 9.0 * random.standard_normal((n, 2))
    theta = Rotation.random(2 * n, random_state=seed).as_quat(scalar_first=True).reshape(n, 2, 4)
    return Poses(vectors[0], angle if dimension == 2 else theta * random.choice([-1.0, 1.0], (n, 2, 1)),
                 vectors[1], spin)  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dimension", [2, 3])
def test_distances_are_lengths_and_angles_sample_by_sample_and_body_by_body(dimension, seed):
    scene, first, second = mixed(dimension), irregular(dimension, seed), irregular(dimension, seed + 100, N_T - 2)
    found = distances(scene, first, second)
    assert found.shape == (N_T - 2, 2, 4)
    for k, b in every(range(N_T - 2), range(2)):
        assert found[k, b, 0] == pytest.approx(math.dist(first.position[k, b], second.position[k, b]))
        assert found[k, b, 2] == pytest.approx(math.dist(first.velocity[k, b], second.velocity[k, b]))
    for k in range(N_T - 2):
        one, other = first.orientation[k, 1], second.orientation[k, 1]
        spins = np.atleast_1d(first.angular_velocity[k, 1]), np.atleast_1d(second.angular_velocity[k, 1])
        angle = (
            math.acos(math.cos(one - other))
            if dimension == 2
            else (
                Rotation.from_quat(one, scalar_first=True) * Rotation.from_quat(other, scalar_first=True).inv()
            ).magnitude()
        )
        assert found[k, 1, 1] == pytest.approx(angle, abs=1e-7)
        assert found[k, 1, 3] == pytest.approx(math.dist(*spins))
    assert np.isnan(found[:, 0, 1::2]).all()  # a particle has no orientation
    assert np.unravel_index(np.nanargmax(found[..., 0]), found.shape[:2]) == (0, 1)


def test_the_largest_distances_count_over_the_scenes_own_length_and_time():
    scene, first, second = mixed(2), irregular(2, 1), irregular(2, 2)
    scales, metres = scales_of(scene), farthest(scene, first, second)
    assert scales.length == pytest.approx(7.0)
    assert relative(scene, first, second).max(axis=0) == pytest.approx(
        [metres[0] / 7.0, metres[1], metres[2] / (7.0 / scales.time), metres[3] * scales.time]
    )
    assert units_of(SCALES) == pytest.approx([2.0, 1.0, 4.0, 2.0])


def test_unknown_is_not_zero():
    scene, first, second = mixed(3), irregular(3, 1), irregular(3, 2)
    found = distances(scene, first, Partial(second.position))
    assert np.isfinite(found[..., 0]).all()
    assert np.isnan(found[..., 1:]).all()
    particle_truth = Partial(second.position, np.zeros((N_T, 2)))  # without Euler parameters
    assert np.isnan(distances(scene, first, particle_truth)[..., 1]).all()
    still = SimpleNamespace(**dict.fromkeys(Poses._fields) | {"velocity": 0.0 * second.velocity})
    assert farthest(scene, first, still)[2] == pytest.approx(np.linalg.norm(first.velocity, axis=2).max())
    assert math.isnan(farthest(scene, first, still)[0])
    hidden = second._replace(position=np.where(np.arange(N_T)[:, None, None] == 2, np.nan, second.position))
    assert np.isnan(relative(scene, first, hidden)[2, 0])
    assert np.isinf(relative(scene, first, hidden, np.inf)[2, 0])


def test_particles_alone_have_no_orientation_whatever_is_given():
    scene = mixed(3)
    dots = tuple(scene.bodies[0].model_copy(update={"name": name}) for name in "ab")
    alone = scene.model_copy(update={"bodies": dots})
    motion = irregular(3, 4)._replace(orientation=np.zeros((N_T, 2)), angular_velocity=np.zeros((N_T, 2)))
    found = distances(alone, motion, irregular(3, 5), np.inf)
    assert np.isnan(found[..., 1::2]).all()
    assert np.isfinite(found[..., ::2]).all()


def test_many_motions_are_compared_at_once_as_one_by_one():
    scene = mixed(3)
    firsts, seconds = ([irregular(3, seed) for seed in seeds] for seeds in ((1, 2), (3, 4)))
    stacked = [Poses(*map(np.stack, zip(*runs, strict=True))) for runs in (firsts, seconds)]
    alone = [distances(scene, one, other) for one, other in zip(firsts, seconds, strict=True)]
    assert np.array_equal(distances(scene, *stacked), alone, equal_nan=True)


def test_a_point_a_radius_of_gyration_away_may_be_further_off_than_the_centre():
    scene, motion = mixed(2), irregular(2, 1)
    turned = motion._replace(orientation=motion.orientation + 0.01)
    assert point_distances(scene, motion, turned)[:, 1, 0] == pytest.approx(0.01 * math.sqrt(6.0 / 2.0))
    assert np.all(point_distances(scene, motion, turned)[:, 0] == 0.0)
    away = motion._replace(velocity=motion.velocity + np.array([3.0, -4.0]))
    assert point_distances(scene, motion, away)[..., 1] == pytest.approx(5.0)


def planar(x: np.ndarray, angle: np.ndarray | float = 0.0, speed: float = 0.0, rate: float = 0.0) -> Poses:
    n = len(x)
    places = np.stack([x, np.zeros(n)], axis=1)[:, None]
    return Poses(places, np.broadcast_to(angle, n)[:, None], np.full((n, 1, 2), [speed, 0.0]), np.full((n, 1), rate))


def turned(theta: tuple[float, ...]) -> Poses:
    still = np.zeros((1, 1, 3))
    return Poses(still, np.array([[theta]]), still, still)


def test_whole_turns_do_not_count():
    x = np.zeros(2)
    assert relative(ROD, planar(x), planar(x, 4.0 * math.pi + 0.1))[:, 1] == pytest.approx([0.1, 0.1])


def test_orientations_that_differ_by_sign_are_the_same():
    quarter = math.cos(math.pi / 4.0), 0.0, math.sin(math.pi / 4.0), 0.0
    one = (1.0, 0.0, 0.0, 0.0)
    assert farthest(TOP, turned(one), turned((-1.0, 0.0, 0.0, 0.0)))[1] == 0.0
    assert farthest(TOP, turned(one), turned(quarter))[1] == pytest.approx(math.pi / 2.0)


def test_a_motion_is_as_large_as_it_goes_from_its_start_and_as_fast():
    times = np.array([0.0, 1.0, 2.0])
    assert motion_size(ROD, SCALES, planar(np.array([1.0, 4.0, 2.0]), 0.0, 1.0, 4.0), times) == pytest.approx(
        [1.5, math.pi, 0.25, 2.0]  # a rate of 4 rad/s, so samples of one angle hide whole turns
    )
    assert motion_size(ROD, SCALES, planar(np.zeros(3), angle=3.0 * times), times)[1] == 3.0
    assert motion_size(ROD, SCALES, planar(np.array([0.0, 1.0, np.nan])), times)[0] == 0.5


def test_a_motion_seen_once_a_period_alone_is_as_large_as_bodies_are_apart():
    places = np.tile(np.array([[0.0, 0.0], [2.0, 0.0]]), (3, 1, 1))
    speeds = np.tile(np.array([[0.0, 0.0], [0.0, 7.0]]), (3, 1, 1))
    pair = Scene(name="pair", bodies=(*DOT.bodies, DOT.bodies[0].model_copy(update={"name": "other"})))
    seen = Poses(places, np.zeros((3, 2)), speeds, np.zeros((3, 2)))
    assert motion_size(pair, SCALES, seen, np.arange(3.0))[0] == 1.0
    assert motion_size(pair, SCALES, seen._replace(velocity=0.0 * speeds), np.arange(3.0))[0] == 0.0


def test_a_body_seen_once_a_turn_alone_turns_as_far_as_its_rates_say():
    times, still = np.arange(3.0), np.zeros((3, 1, 3))
    upright = Poses(still, np.tile([1.0, 0.0, 0.0, 0.0], (3, 1, 1)), still, still)

    def turn(*rates: float) -> float:
        """Return the size of the turn (rad) of a body with these rates (rad/s) about one axis."""
        spin = np.array(rates)[:, None, None] * np.array([0.0, 0.6, 0.8])
        return float(motion_size(TOP, SCALES, upright._replace(angular_velocity=spin), times)[1])

    assert turn(6.0, 6.0, 6.0) == np.pi
    assert turn(1.0, 1.0, 0.5) == pytest.approx(1.75)
    assert turn(1.0, -1.0, 1.0) == 0.0


def test_a_tolerance_is_relative_to_the_largest_coordinate_or_to_a_radian():
    assert coordinate_size(SCALES, planar(np.array([0.0, -7.0])).position) == 3.5
    assert coordinate_size(SCALES, planar(np.zeros(2)).position) == 1.0
