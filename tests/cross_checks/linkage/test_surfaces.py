"""Convex shapes that stand for those of a contact."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.linkage.surfaces import body_refusals, gap_walls
from mbs_ref import scenes
from mbs_ref.scene import GROUND, PlanarBody, Scene
from mbs_ref.scene.contact import PinOnSprocket, SpringDamperLaw
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

RADIUS, TIP, CLEARANCE, FLANK = 0.25, 0.262, 5e-4, 0.35  # m, rad


@pytest.mark.parametrize(("turn", "out", "aside"), [(0.4, 4e-3, 4e-3), (0.4, 6e-3, -5e-3), (-2.0, 1e-3, 1.5e-3)])
def test_walls_of_a_gap_are_as_far_as_the_pins_contact_says(turn, out, aside):
    """A pin off its seat (m, rad), on a straight flank."""
    ahead = turn + 2.0 * np.pi * 3.0 / 7.0
    radial, across = np.array([np.cos(ahead), np.sin(ahead)]), np.array([-np.sin(ahead), np.cos(ahead)])
    place = (RADIUS + out) * radial + aside * across
    bodies = (PlanarBody(name="wheel", mass=1.0, inertia=1.0, position=(0.0, 0.0)),
              PlanarBody(name="link", mass=1.0, inertia=1.0, position=tuple(place.tolist())))  # fmt: skip
    pin = PinOnSprocket(
        name="pin", body_a="link", center=bodies[1].position, body_b="wheel", axle=(0.0, 0.0), teeth=7,
        pitch_radius=RADIUS, addendum_radius=TIP, first_seat=turn, clearance=CLEARANCE, flank_angle=FLANK,
        law=SpringDamperLaw(stiffness=1e3),
    )  # fmt: skip
    path = simulate(Scene(name="tooth", bodies=bodies, contacts=(pin,)), Settings(t_end=1e-9, estimate="off"))
    boxes = [wall for wall in gap_walls(pin) if wall.kind == "box"]
    assert len(boxes) == 14
    local = np.array([wall.axes.T @ ((*place, 0.0) - wall.middle) for wall in boxes])
    size = np.array([wall.size for wall in boxes])
    inside = (np.abs(local[:, :2]) < size[:, :2]).all(axis=1)
    depth = (size[:, 2] - local[:, 2])[inside & (local[:, 2] > -size[:, 2])]
    assert depth.max() == pytest.approx(path.contacts["pin"][0, 0], abs=1e-12)


def test_walls_end_at_the_tips_of_the_teeth():
    pin = PinOnSprocket(name="pin", body_a="link", center=(0.0, RADIUS), body_b="wheel", axle=(0.0, 0.0), teeth=5,
                        pitch_radius=RADIUS, addendum_radius=TIP, clearance=CLEARANCE, flank_angle=FLANK,
                        law=SpringDamperLaw(stiffness=1e3))  # fmt: skip
    root, *boxes = gap_walls(pin)
    assert root.size[0] == pytest.approx(RADIUS - CLEARANCE)
    for wall in boxes:
        tip = wall.middle + wall.axes @ (wall.size[0], 0.0, wall.size[2])
        assert np.linalg.norm(tip) == pytest.approx(TIP)
        assert np.linalg.det(wall.axes) == pytest.approx(1.0)


def test_shapes_that_would_touch_undeclared_and_two_laws_of_a_body_are_refused():
    block, stack = scenes.make("sliding_block"), scenes.make("box_stack")
    assert not list(body_refusals("x", block, (*block.body_names, GROUND)))
    reasons = list(body_refusals("x", stack, stack.body_names))
    assert any("'box0' and 'ground'" in why for why in reasons)  # its top and the floor
    first, *rest = block.contacts
    soft = first.model_copy(update={"law": SpringDamperLaw(stiffness=1.0)})
    two = block.model_copy(update={"contacts": (soft, *rest)})
    assert ["one law" in why for why in body_refusals("x", two, block.body_names)] == [True]
