"""The motion of links, against the judge's constraints and finite differences."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.linkage.links import linkage_of
from cross_checks.linkage.motion import BALL, FREE, arrays_of, motion_of, poses_of, project
from cross_checks.truths.oracle.random_scenes import random_scene
from mbs_ref.observables import rows
from mbs_ref.scene import GROUND, Distance, PlanarBody, PointMass, Prismatic, Revolute, Scene, Weld
from mbs_ref.scene.euler_parameters import conjugate, from_axis_angle, product, rotation_matrices
from mbs_ref.trajectory import Trajectory

SPATIAL = (0, 13, 36, 68)  # seeds of random scenes that have every kind of link in space


def mixed_tree() -> Scene:
    """A turned slider with a rod, a welded plate, a pinned particle, a particle on a rod and a free body."""
    slider = PlanarBody(name="slider", mass=1.0, inertia=0.2, position=(1.0, 0.5), angle=0.3)
    rod = PlanarBody(name="rod", mass=2.0, inertia=0.3, position=(1.5, 0.2), angle=-0.4)
    plate = PlanarBody(name="plate", mass=0.5, inertia=0.1, position=(2.0, 0.4), angle=1.1)
    pinned = PointMass(name="pinned", mass=0.3, position=(1.8, -0.1), velocity=(0.0, 0.0))
    bob = PointMass(name="bob", mass=0.7, position=(2.5, -0.3), velocity=(0.0, 0.0))
    free = PlanarBody(
        name="free", mass=1.0, inertia=0.1, position=(-1.0, 2.0), velocity=(1.0, -2.0), angular_velocity=3.0
    )
    return Scene(
        name="mixed",
        gravity=(0.0, -9.81),
        bodies=(bob, plate, rod, slider, free, pinned),
        joints=(
            Prismatic(name="guide", body_a="slider", body_b=GROUND, point=(1.0, 0.5), axis=(2.0, 1.0)),
            Revolute(name="hinge", body_a="rod", body_b="slider", point=(1.2, 0.4)),
            Weld(name="glue", body_a="rod", body_b="plate", point=(1.7, 0.3)),
            Revolute(name="nail", body_a="plate", body_b="pinned", point=(1.8, -0.1)),
            Distance(name="string", body_a="bob", body_b="plate", point_a=(2.5, -0.3), point_b=(2.2, 0.5)),
        ),
    )


TREES = [mixed_tree(), *(random_scene(seed, most=8) for seed in SPATIAL)]
each_tree = pytest.mark.parametrize("scene", TREES, ids=[scene.name for scene in TREES])


def neutral(arrays) -> np.ndarray:
    """Return the coordinates at t = 0."""
    q = np.zeros(int(arrays.place[-1]) + 7)
    for place, kind in zip(arrays.place, arrays.kind, strict=True):
        if kind in (BALL, FREE):
            q[place + (6 if kind == FREE else 3)] = 1.0
    return q


def moved(arrays, q, step):
    """Return coordinates after a step: of slides and turns the sum, of quaternions a turn in the link's axes."""
    q = q.copy()
    for kind, i, j in zip(arrays.kind, arrays.place, arrays.rate, strict=False):
        if kind not in (BALL, FREE):
            q[i] += step[j]
            continue
        if kind == FREE:
            q[i : i + 3] += rotation_matrices(q[[i + 6, i + 3, i + 4, i + 5]]) @ step[j : j + 3]
            i, j = i + 3, j + 3
        turn, theta = step[j : j + 3], [i + 3, i, i + 1, i + 2]
        q[theta] = product(q[theta], from_axis_angle(turn, np.linalg.norm(turn)))
    return q


def states(linkage):
    """Yield coordinates and rates of a few random states."""
    generator, arrays = np.random.default_rng(1), arrays_of(linkage)
    for _ in range(5):
        step, v = generator.normal(size=(2, len(linkage.rates)))
        yield moved(arrays, neutral(arrays), step), v


def test_every_kind_of_link_is_in_a_tree():
    kinds = {link.kind for scene in TREES for link in linkage_of(scene).links}
    assert kinds == {"revolute", "prismatic", "cylindrical", "universal", "ball", "planar", "weld", "free"}


@each_tree
def test_coordinates_satisfy_the_trees_joints_at_both_levels(scene):
    linkage = linkage_of(scene)
    arrays, held = arrays_of(linkage), {link.joint for link in linkage.links}
    tree = scene.model_copy(update={"joints": tuple(joint for joint in scene.joints if joint.name in held)})
    poses = poses_of(linkage, (motion_of(arrays, q, v)[0] for q, v in states(linkage)))
    constraints = rows(tree, Trajectory(np.arange(5.0), *poses))
    assert np.abs(constraints.residual).max(initial=0.0) < 1e-12
    assert np.abs(constraints.rate).max(initial=0.0) < 1e-11


@each_tree
def test_velocities_are_the_derivatives_of_poses(scene):
    linkage, h = linkage_of(scene), 1e-6
    arrays = arrays_of(linkage)
    for q, v in states(linkage):
        motion, _ = motion_of(arrays, q, v)
        ahead, behind = (motion_of(arrays, moved(arrays, q, step * v), v)[0] for step in (h, -h))
        assert (ahead.position - behind.position) / (2 * h) == pytest.approx(motion.velocity, abs=1e-7)
        turned = product(ahead.turn, conjugate(behind.turn))
        assert turned[:, 1:] / h * np.sign(turned[:, :1]) == pytest.approx(motion.omega, abs=1e-7)


@each_tree
def test_rates_at_the_start_are_the_bodies_velocities(scene):
    linkage = linkage_of(scene)
    arrays = arrays_of(linkage)
    position, _, velocity, _ = poses_of(linkage, [motion_of(arrays, neutral(arrays), linkage.rates)[0]])
    assert position[0] == pytest.approx(np.array([body.position for body in scene.bodies]), abs=1e-13)
    assert velocity[0] == pytest.approx(np.array([body.velocity for body in scene.bodies]), abs=1e-12)


@each_tree
def test_projected_forces_do_the_work_of_the_forces(scene):
    linkage = linkage_of(scene)
    arrays, wrench = arrays_of(linkage), np.random.default_rng(2).normal(size=(len(scene.bodies), 6))
    for q, v in states(linkage):
        motion, axes = motion_of(arrays, q, v)
        power = np.sum(wrench[:, :3] * motion.velocity) + np.sum(wrench[:, 3:] * motion.omega)
        assert project(arrays, motion, axes, wrench) @ v == pytest.approx(power, abs=1e-11)
