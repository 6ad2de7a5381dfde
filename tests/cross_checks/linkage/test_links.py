"""Scenes as links in space: what they start from is the scene's own data, whatever the joint."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.linkage.links import Link, closure_refusals, linkage_of
from mbs_ref import scenes
from mbs_ref.scene import GROUND, PlanarBody, PointMass, Revolute, Scene, SpatialBody, Spherical
from tests.cross_checks.linkage.test_motion import mixed_tree

LINKED = (
    "pendulum", "double_pendulum", "slider_crank", "n_four_bar", "spring_pendulum", "bouncing_ball", "andrews",
    "heavy_top", "spatial_chain", "torque_free_top", "spatial_slider_crank", "flyball_governor", "spherical_pendulum",
)  # fmt: skip


def relative(link: Link) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocity of the origin and the angular velocity that a link's rates give it over its parent."""
    rates, none = link.rates, np.zeros(3)
    return {
        "revolute": lambda: (none, rates @ link.axes),
        "prismatic": lambda: (rates @ link.axes, none),
        "cylindrical": lambda: (rates[0] * link.axes[0], rates[1] * link.axes[1]),
        "universal": lambda: (none, rates @ link.axes),
        "ball": lambda: (none, rates),
        "planar": lambda: (np.array([*rates[:2], 0.0]), np.array([0.0, 0.0, rates[2]])),
        "free": lambda: (rates[:3], rates[3:]),
        "weld": lambda: (none, none),
    }[link.kind]()


@pytest.mark.parametrize("name", LINKED)
def test_rates_of_the_links_move_bodies_as_the_scene_says(name):
    scene = scenes.make(name)
    linkage = linkage_of(scene)
    at, speed, spin = {-1: np.zeros(3)}, {-1: np.zeros(3)}, {-1: np.zeros(3)}
    for link in linkage.links:
        slide, turn = relative(link)
        p = link.parent
        at[link.body] = link.origin
        spin[link.body] = spin[p] + turn
        speed[link.body] = speed[p] + np.cross(spin[p], link.origin - at[p]) + slide
        body = scene.bodies[link.body]
        centre = speed[link.body] + np.cross(spin[link.body], link.centre)
        assert centre[: scene.dimension] == pytest.approx(body.velocity, abs=1e-12)
        assert (link.origin + link.centre)[: scene.dimension] == pytest.approx(body.position, abs=1e-15)
        if isinstance(body, PlanarBody):
            assert spin[link.body][2] == pytest.approx(body.angular_velocity, abs=1e-12)
            assert link.inertia == pytest.approx(body.inertia * np.eye(3))
        if isinstance(body, SpatialBody):
            assert spin[link.body] == pytest.approx(body.angular_velocity, abs=1e-12)
            moments = np.linalg.eigvalsh(link.inertia)  # turned, not changed
            assert moments == pytest.approx(np.linalg.eigvalsh(body.inertia_matrix))


def test_a_coordinate_that_a_drive_keeps_constant_is_no_freedom():
    free, held = (scenes.make(name) for name in ("bouncing_ball", "woodpecker"))
    assert [kind for kind, _ in linkage_of(free).links[0].freedoms] == ["slide", "slide", "turn"]
    sleeve = linkage_of(held).of_body[held.body_index("sleeve")]
    assert [(kind, axis.tolist()) for kind, axis in sleeve.freedoms] == [("slide", [0, 1, 0]), ("turn", [0, 0, 1])]
    assert sleeve.size == len(sleeve.rates) == 2
    driven = scenes.make("ball_on_driven_seat")  # x and the angle stay, y moves
    seat = linkage_of(driven).of_body[driven.body_index("seat")]
    assert [axis.tolist() for _, axis in seat.freedoms] == [[0, 1, 0]]


@pytest.mark.parametrize("name", ["slider_crank", "spatial_slider_crank"])
def test_a_slide_stays_in_the_tree_and_a_shared_point_closes_the_loop(name):
    linkage = linkage_of(scenes.make(name))
    assert "prismatic" in [link.kind for link in linkage.links]
    assert [closure.kind for closure in linkage.closures] == ["point"]


def test_a_four_bars_loops_are_counted_and_its_tree_is_shallow():
    scene = scenes.make("n_four_bar", loops=4)
    linkage = linkage_of(scene)
    assert len(linkage.closures) == 4
    assert max(len(list(linkage.path(name))) for name in scene.body_names) == 2


def test_every_body_hangs_on_an_earlier_one_and_hinges_turn_what_they_carry():
    linkage = linkage_of(mixed_tree())
    seen = [-1]
    for link in linkage.links:
        assert link.parent in seen
        seen.append(link.body)
    assert sorted(seen) == list(range(-1, 6))
    assert not linkage.closures
    assert [link.size for link in linkage.of_body] == [1, 0, 1, 1, 3, 0]
    assert linkage.turns.sum(axis=1).tolist() == [2.0, 1.0, 1.0, 0.0, 1.0, 1.0]


def test_a_particle_on_a_ball_joint_is_welded_to_its_parent():
    rod = SpatialBody(name="rod", mass=1.0, inertia=(0.1, 0.1, 0.1, 0.0, 0.0, 0.0), position=(0.5, 0.0, 0.0))
    bob = PointMass(name="bob", mass=1.0, position=(1.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
    joints = (
        Spherical(name="pivot", body_a=GROUND, body_b="rod", point=(0.0, 0.0, 0.0)),
        Spherical(name="hook", body_a="rod", body_b="bob", point=bob.position),
    )
    scene = Scene(name="hung", gravity=(0.0, 0.0, -9.81), bodies=(rod, bob), joints=joints)
    hung = next(link for link in linkage_of(scene).links if link.name == "bob")
    assert (hung.kind, hung.size, hung.inertia.any()) == ("weld", 0, False)


def test_a_body_on_a_pinned_particle_turns_against_what_carries_the_particle():
    arm = PlanarBody(name="arm", mass=1.0, inertia=0.1, position=(0.5, 0.0), velocity=(0.0, 1.0), angular_velocity=2.0)
    tip = PointMass(name="tip", mass=1.0, position=(1.0, 0.0), velocity=(0.0, 2.0))
    rod = PlanarBody(name="rod", mass=1.0, inertia=0.1, position=(1.5, 0.0), velocity=(0.0, 3.5), angular_velocity=3.0)
    joints = (
        Revolute(name="pivot", body_a=GROUND, body_b="arm", point=(0.0, 0.0)),
        Revolute(name="nail", body_a="arm", body_b="tip", point=(1.0, 0.0)),
        Revolute(name="hinge", body_a="tip", body_b="rod", point=(1.0, 0.0)),
    )
    linkage = linkage_of(Scene(name="carried", gravity=(0.0, 0.0), bodies=(arm, tip, rod), joints=joints))
    assert linkage.rates == pytest.approx([2.0, 1.0], abs=1e-15)


def test_loops_that_an_engine_does_not_support_are_named():
    assert not closure_refusals("some", scenes.make("n_four_bar"), {"point"})
    (refusal,) = closure_refusals("some", scenes.make("spherical_pendulum"), {"point", "hinge"})
    assert refusal.reason == "joint 'rod' closes a loop as rod, which some does not yet support"
    assert not refusal.permanent
