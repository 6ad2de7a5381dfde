"""Distances between poses, and how far a motion goes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mbs_ref.cores.system import Poses
from mbs_ref.scene import PlanarBody, PointMass, Scene, SpatialBody
from mbs_ref.self_checks.pose_gap import coordinate_size, motion_size, pose_gap

ROD = Scene(name="rod", bodies=(PlanarBody(name="rod", mass=4.0, inertia=1.0),))  # gyrates at 0.5 m
TOP = Scene(
    name="top",
    gravity=(0.0, 0.0, 0.0),
    bodies=(SpatialBody(name="top", mass=1.0, inertia=(0.03, 0.03, 0.04, 0.0, 0.0, 0.0)),),
)  # gyrates at 0.2 m
DOT = Scene(name="dot", bodies=(PointMass(name="dot", mass=1.0, position=(0.0, 0.0), velocity=(0.0, 0.0)),))


def planar(x: np.ndarray, angle: np.ndarray | float = 0.0, speed: float = 0.0) -> Poses:
    n = len(x)
    places = np.stack([x, np.zeros(n)], axis=1)[:, None]
    return Poses(places, np.broadcast_to(angle, n)[:, None], np.full((n, 1, 2), [speed, 0.0]), np.zeros((n, 1)))


def turned(theta: list[float]) -> Poses:
    still = np.zeros((1, 1, 3))
    return Poses(still, np.array([[theta]]), still, still)


def test_a_gap_is_the_larger_of_the_centres_and_of_a_point_at_the_radius_of_gyration():
    x = np.array([0.0, 3.0])
    assert pose_gap(ROD, planar(x), planar(x + 0.25)) == pytest.approx([0.25, 0.25])
    assert pose_gap(ROD, planar(x), planar(x, angle=4.0 * math.pi)) == pytest.approx([2.0 * math.pi] * 2)
    assert np.all(pose_gap(ROD, planar(x), planar(x, angle=np.array([0.0, np.nan]))) == [0.0, np.inf])


def test_orientations_that_differ_by_sign_are_the_same():
    quarter = math.cos(math.pi / 4.0), 0.0, math.sin(math.pi / 4.0), 0.0
    assert pose_gap(TOP, turned([1.0, 0.0, 0.0, 0.0]), turned([-1.0, 0.0, 0.0, 0.0])) == pytest.approx([0.0])
    assert pose_gap(TOP, turned([1.0, 0.0, 0.0, 0.0]), turned(list(quarter))) == pytest.approx([0.2 * math.pi / 2.0])


def test_a_motion_is_as_large_as_it_goes_from_its_start_and_a_turn_counts_by_half():
    times = np.array([0.0, 1.0, 2.0])
    assert motion_size(ROD, planar(np.array([1.0, 4.0, 2.0])), times) == 3.0
    assert motion_size(ROD, planar(np.zeros(3), angle=100.0 * times), times) == pytest.approx(0.5 * math.pi)
    assert motion_size(ROD, planar(np.array([0.0, 1.0, np.nan])), times) == 1.0


def test_a_motion_seen_once_a_period_alone_is_as_large_as_bodies_are_apart():
    places = np.tile(np.array([[0.0, 0.0], [2.0, 0.0]]), (3, 1, 1))
    speeds = np.tile(np.array([[0.0, 0.0], [0.0, 7.0]]), (3, 1, 1))
    pair = Scene(name="pair", bodies=(*DOT.bodies, DOT.bodies[0].model_copy(update={"name": "other"})))
    seen = Poses(places, np.zeros((3, 2)), speeds, np.zeros((3, 2)))
    assert motion_size(pair, seen, np.arange(3.0)) == 2.0
    assert motion_size(pair, seen._replace(velocity=0.0 * speeds), np.arange(3.0)) == 0.0


def test_a_tolerance_is_relative_to_the_largest_coordinate_or_body():
    assert coordinate_size(ROD, planar(np.array([0.0, -7.0]))) == 7.0
    assert coordinate_size(ROD, planar(np.zeros(2))) == 0.5
