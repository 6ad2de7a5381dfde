"""Scenes as links in space: what they start from is the scene's own data, whatever the joint."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.workshop.linkage import Link, closure_refusals, linkage_of
from mbs_ref import scenes
from mbs_ref.scene import PlanarBody, SpatialBody

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


def test_loops_that_an_engine_is_not_taught_are_named():
    assert not closure_refusals("some", scenes.make("n_four_bar"), {"point"})
    (refusal,) = closure_refusals("some", scenes.make("spherical_pendulum"), {"point", "hinge"})
    assert refusal.reason == "joint 'rod' closes a loop as rod, which some is not yet taught"
    assert not refusal.permanent
