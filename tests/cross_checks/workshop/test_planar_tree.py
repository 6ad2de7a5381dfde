"""The spanning tree and its kinematics, against the judge's constraints and finite differences."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.workshop.initial_state import inconsistency, worst_gap
from cross_checks.workshop.planar_motion import arrays_of, motion_of, project
from cross_checks.workshop.planar_tree import joint_tree
from mbs_ref import scenes
from mbs_ref.observables import rows
from mbs_ref.scene import GROUND, Distance, PlanarBody, PointMass, Prismatic, Revolute, Scene, Weld
from mbs_ref.trajectory import Trajectory


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


def motion(tree, seed=1):
    rng = np.random.default_rng(seed)
    start, rate = rng.normal(size=(2, tree.size))
    times = np.linspace(0.0, 1.0, 5)
    return times, np.outer(times, start) + np.outer(np.sin(times), rate), start + np.outer(np.cos(times), rate)


def test_every_body_hangs_on_an_earlier_one():
    tree = joint_tree(mixed_tree())
    seen = {-1}
    for edge in tree.edges:
        assert edge.parent in seen
        seen.add(edge.body)
    assert seen == set(range(-1, 6))
    assert tree.closures == ()
    assert tree.size == 1 + 1 + 0 + 0 + 1 + 3


def test_coordinates_satisfy_every_joint_at_both_levels():
    scene = mixed_tree()
    tree = joint_tree(scene)
    times, q, v = motion(tree)
    found = rows(scene, Trajectory(times, *tree.poses(q, v)))
    assert np.abs(found.residual).max() < 1e-13
    assert np.abs(found.rate).max() < 1e-12


def test_velocities_are_the_derivatives_of_poses():
    tree = joint_tree(mixed_tree())
    _, q, v = motion(tree)
    h = 1e-6
    ahead, behind = tree.poses(q + h * v, v), tree.poses(q - h * v, v)
    _, _, velocity, rate = tree.poses(q, v)
    assert (ahead[0] - behind[0]) / (2 * h) == pytest.approx(velocity, abs=1e-8)
    assert (ahead[1] - behind[1]) / (2 * h) == pytest.approx(rate, abs=1e-8)


def test_rates_from_the_bodies_velocities_reproduce_them():
    scene = mixed_tree()
    tree = joint_tree(scene)
    _, _, v = motion(tree)
    _, _, velocity, rate = tree.poses(np.zeros((1, tree.size)), v[:1])
    moving = tuple(
        body.model_copy(
            update={"velocity": tuple(velocity[0, k])}
            | ({"angular_velocity": float(rate[0, k])} if isinstance(body, PlanarBody) else {})
        )
        for k, body in enumerate(scene.bodies)
    )
    assert joint_tree(scene.model_copy(update={"bodies": moving})).rates() == pytest.approx(v[0], abs=1e-12)


def test_projected_forces_do_the_work_of_the_forces():
    tree = joint_tree(mixed_tree())
    _, q, v = motion(tree)
    forces = np.random.default_rng(2).normal(size=(6, 3))
    position, _, velocity, rate = tree.poses(q, v)
    for k in range(len(q)):
        power = np.sum(forces[:, :2] * velocity[k]) + forces[:, 2] @ rate[k]
        assert tree.project(q[k], position[k], forces) @ v[k] == pytest.approx(power, abs=1e-12)


def test_compiled_motion_and_forces_are_those_of_the_tree():
    tree = joint_tree(mixed_tree())
    _, q, v = motion(tree)
    arrays, forces = arrays_of(tree), np.random.default_rng(3).normal(size=(6, 3))
    position, angle, velocity, rate = tree.poses(q, v)
    for k in range(len(q)):
        pose, speed = motion_of(arrays, q[k], v[k])
        assert np.abs(pose - np.column_stack((position[k], angle[k]))).max() < 1e-14
        assert np.abs(speed - np.column_stack((velocity[k], rate[k]))).max() < 1e-14
        power = np.sum(forces[:, :2] * velocity[k]) + forces[:, 2] @ rate[k]
        assert project(arrays, q[k], pose, forces) @ v[k] == pytest.approx(power, abs=1e-12)


def test_a_slide_stays_in_the_tree_and_a_pin_closes_the_loop():
    tree = joint_tree(scenes.make("slider_crank"))
    assert [type(joint) for joint in tree.closures] == [Revolute]
    assert tree.size == 3


def test_a_four_bars_loops_are_counted_and_its_tree_is_shallow():
    tree = joint_tree(scenes.make("n_four_bar", loops=4))
    assert len(tree.closures) == 4
    assert max(len(tree.path(k)) for k in range(len(tree.scene.bodies))) == 2


def test_a_loop_that_starts_open_is_named():
    scene = scenes.make("n_four_bar", loops=1)
    opened = [
        joint.model_copy(update={"point_b": (joint.point[0], joint.point[1] + 0.25)}) if joint.name == "A1" else joint
        for joint in scene.joints
        if isinstance(joint, Revolute)
    ]
    assert inconsistency(scene, 1e-9) == ""
    assert "'A1' starts 0.25 m open" in inconsistency(scene.model_copy(update={"joints": tuple(opened)}), 1.0)


def test_the_worst_gap_names_its_joint():
    scene = mixed_tree()
    assert worst_gap(scene.model_copy(update={"joints": ()})) is None
    bad = scene.joints[-1].model_copy(update={"length": 2.0})
    gap = worst_gap(scene.model_copy(update={"joints": (*scene.joints[:-1], bad)}))
    assert gap is not None
    assert gap.joint == "string"
    assert gap.position == pytest.approx(2.0 - np.hypot(0.3, 0.8))
