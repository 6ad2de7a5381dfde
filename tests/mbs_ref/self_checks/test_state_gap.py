"""Distances between runs over the scene's own scales, and how far a motion goes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cross_checks.metrics.state_error import differences
from mbs_ref import scenes
from mbs_ref.cores.system import Poses
from mbs_ref.scene import PlanarBody, PointMass, Scene, SpatialBody
from mbs_ref.scene.scales import Scales, scales_of
from mbs_ref.self_checks.state_gap import coordinate_size, state_gaps, state_sizes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

ROD = Scene(name="rod", bodies=(PlanarBody(name="rod", mass=4.0, inertia=1.0),))
TOP = Scene(
    name="top",
    gravity=(0.0, 0.0, 0.0),
    bodies=(SpatialBody(name="top", mass=1.0, inertia=(0.03, 0.03, 0.04, 0.0, 0.0, 0.0)),),
)
DOT = Scene(name="dot", bodies=(PointMass(name="dot", mass=1.0, position=(0.0, 0.0), velocity=(0.0, 0.0)),))
SCALES = Scales(length=2.0, time=0.5)


def planar(x: np.ndarray, angle: np.ndarray | float = 0.0, speed: float = 0.0, rate: float = 0.0) -> Poses:
    n = len(x)
    places = np.stack([x, np.zeros(n)], axis=1)[:, None]
    return Poses(places, np.broadcast_to(angle, n)[:, None], np.full((n, 1, 2), [speed, 0.0]), np.full((n, 1), rate))


def turned(theta: tuple[float, ...]) -> Poses:
    still = np.zeros((1, 1, 3))
    return Poses(still, np.array([[theta]]), still, still)


def test_every_component_counts_over_its_scale():
    x = np.array([0.0, 3.0])
    gaps = state_gaps(ROD, SCALES, planar(x), planar(x + 1.0, 0.1, 4.0, 6.0))
    assert gaps == pytest.approx(np.array([[0.5, 0.1, 1.0, 3.0]] * 2))
    assert np.all(state_gaps(DOT, SCALES, planar(x), planar(x, 0.1, 0.0, 6.0)) == 0.0)  # a particle has no orientation


def test_whole_turns_do_not_count_and_what_is_not_finite_is_infinitely_far():
    x = np.zeros(2)
    assert state_gaps(ROD, SCALES, planar(x), planar(x, 4.0 * math.pi + 0.1))[:, 1] == pytest.approx([0.1, 0.1])
    assert np.all(state_gaps(ROD, SCALES, planar(x), planar(x, np.array([0.0, np.nan])))[:, 1] == [0.0, np.inf])


def test_orientations_that_differ_by_sign_are_the_same():
    quarter = math.cos(math.pi / 4.0), 0.0, math.sin(math.pi / 4.0), 0.0
    one = (1.0, 0.0, 0.0, 0.0)
    assert state_gaps(TOP, SCALES, turned(one), turned((-1.0, 0.0, 0.0, 0.0)))[0, 1] == 0.0
    assert state_gaps(TOP, SCALES, turned(one), turned(quarter))[0, 1] == pytest.approx(math.pi / 2.0)


@pytest.mark.parametrize("name", ["double_pendulum", "heavy_top", "kepler"])
def test_the_gap_is_what_the_judge_measures(name):
    scene = scenes.make(name)
    first, second = (simulate(scene, Settings(rtol=r, samples=11, estimate="off")) for r in (1e-3, 1e-8))
    poses = [Poses(path.position, path.orientation, path.velocity, path.angular_velocity) for path in (first, second)]
    scales = scales_of(scene)
    judged = differences(scene, first, second).relative(scales)
    assert judged.max() > 0.0
    assert state_gaps(scene, scales, *poses) == pytest.approx(judged, rel=1e-12)


def test_a_motion_is_as_large_as_it_goes_from_its_start_and_as_fast():
    times = np.array([0.0, 1.0, 2.0])
    assert state_sizes(ROD, SCALES, planar(np.array([1.0, 4.0, 2.0]), 0.0, 1.0, 4.0), times) == pytest.approx(
        [1.5, 0.0, 0.25, 2.0]
    )
    assert state_sizes(ROD, SCALES, planar(np.zeros(3), angle=3.0 * times), times)[1] == 3.0
    assert state_sizes(ROD, SCALES, planar(np.array([0.0, 1.0, np.nan])), times)[0] == 0.5


def test_a_motion_seen_once_a_period_alone_is_as_large_as_bodies_are_apart():
    places = np.tile(np.array([[0.0, 0.0], [2.0, 0.0]]), (3, 1, 1))
    speeds = np.tile(np.array([[0.0, 0.0], [0.0, 7.0]]), (3, 1, 1))
    pair = Scene(name="pair", bodies=(*DOT.bodies, DOT.bodies[0].model_copy(update={"name": "other"})))
    seen = Poses(places, np.zeros((3, 2)), speeds, np.zeros((3, 2)))
    assert state_sizes(pair, SCALES, seen, np.arange(3.0))[0] == 1.0
    assert state_sizes(pair, SCALES, seen._replace(velocity=0.0 * speeds), np.arange(3.0))[0] == 0.0


def test_a_tolerance_is_relative_to_the_largest_coordinate_or_to_a_radian():
    assert coordinate_size(SCALES, planar(np.array([0.0, -7.0]))) == 3.5
    assert coordinate_size(SCALES, planar(np.zeros(2))) == 1.0
