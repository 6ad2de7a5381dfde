"""What a scene's image is made of, by hand: places, directions in a body, spans, orders, and what has no image."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.conformance.symmetry import _reordered, placement
from cross_checks.conformance.symmetry.placement import Placement, cut_obstacle, dimension, image
from cross_checks.engine.plan import initial_sample
from mbs_ref import scenes
from mbs_ref.observables.attachment import Motion
from mbs_ref.observables.contact_gap import gap_of
from mbs_ref.scene import Force, PlanarBody, Scene, SpatialBody, SpringDamper
from mbs_ref.scene.celestial import Newton, Relativity
from mbs_ref.scene.euler_parameters import rotation_matrices
from mbs_ref.scene.signals import Table

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
ASKEW = np.array([[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]]) / 3.0


def test_a_point_is_turned_then_shifted_then_measured_in_the_other_unit():
    placement = Placement(QUARTER, np.array([10.0, 20.0]), length=2.0)
    assert placement.points(np.array([[1.0, 3.0]])).tolist() == [[2.0 * (10.0 - 3.0), 2.0 * (20.0 + 1.0)]]


def test_a_scene_lasts_as_much_longer_as_a_second_has_become():
    placement = Placement(np.eye(2), np.zeros(2), time=8.0)
    scene = scenes.make("double_pendulum").model_copy(update={"duration": 3.0})
    assert image(scene, placement).duration == 24.0


def _pushed_along_its_own_axes(dimension: int) -> Scene:
    if dimension == 2:
        body, push = PlanarBody(name="body", mass=1.0, inertia=1.0, angle=0.4), (1.0, 2.0)
    else:
        half = 0.6  # rad, of the turn about the axis (2, 3, 6) / 7
        theta = (math.cos(half), *(math.sin(half) * np.array([2.0, 3.0, 6.0]) / 7.0).tolist())
        body = SpatialBody(name="body", mass=1.0, inertia=(1.0, 2.0, 2.5, 0.1, 0.2, 0.3), orientation=theta)
        push = (1.0, 2.0, 3.0)
    load = Force(name="push", body="body", point=(0.0,) * dimension, vector=push, frame="body")
    return Scene(name="pushed", gravity=(0.0,) * dimension, bodies=(body,), loads=(load,))


def _in_world(scene: Scene) -> np.ndarray:
    """Return the force on the scene's body along the axes of the world."""
    body, load = scene.bodies[0], scene.loads[0]
    assert isinstance(load, Force)
    if isinstance(body, PlanarBody):
        c, s = math.cos(body.angle), math.sin(body.angle)
        return np.array([[c, -s], [s, c]]) @ load.vector
    assert isinstance(body, SpatialBody)
    return rotation_matrices(np.array(body.orientation)) @ load.vector


@pytest.mark.parametrize("sense", [1.0, -1.0], ids=["turned", "mirrored"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_force_in_a_bodys_axes_points_where_its_image_in_the_world_points(dimension, sense):
    scene = _pushed_along_its_own_axes(dimension)
    matrix = (QUARTER if dimension == 2 else ASKEW) @ np.diag([1.0] * (dimension - 1) + [sense])
    seen = image(scene, Placement(matrix, np.zeros(dimension)))
    assert _in_world(seen) == pytest.approx(matrix @ _in_world(scene), abs=1e-14)


def test_bodies_stand_in_reverse_but_for_one_whose_field_alone_is_counted():
    """Einstein's field of the first body singles it out; fields of all with one another single out none."""
    scene = scenes.make("figure_eight")
    central, mutual = (Relativity(name="einstein", form=form) for form in ("central", "eih"))
    assert _reordered(scene).order == (2, 1, 0)
    assert _reordered(scene.model_copy(update={"loads": (*scene.loads, mutual)})).order == (2, 1, 0)
    assert _reordered(scene.model_copy(update={"loads": (*scene.loads, central)})).order == (0, 2, 1)


def test_a_force_that_varies_is_not_carried_over_a_cut_and_a_constant_one_is():
    steady = _pushed_along_its_own_axes(2)
    ramp = Table(times=(0.0, 1.0), values=(0.0, 1.0))
    varied = steady.model_copy(update={"loads": (steady.loads[0].model_copy(update={"factor": ramp}),)})
    assert placement.cut_obstacle(steady, back=False) == ""
    assert placement.cut_obstacle(varied, back=False) == "signals are not carried over a cut"


@pytest.mark.parametrize("matrix", [QUARTER, QUARTER * [[1.0], [-1.0]]], ids=["turned", "mirrored"])
def test_a_ball_is_on_the_free_side_of_the_image_of_a_line(matrix):
    scene = scenes.make("bouncing_ball")
    placement = Placement(matrix, np.array([0.3, -0.7]), length=2.0)
    seen = image(scene, placement)
    (before,), (after,) = (gap_of(Motion(one, initial_sample(one)), one.contacts[0])[0] for one in (scene, seen))
    assert after == pytest.approx(2.0 * before)


def test_moduli_of_soil_have_the_powers_of_their_formula():
    """p = (k_c / b + k_phi) z^n in Pa: k_c in kg m^-n s^-2, k_phi in kg m^-(n + 1) s^-2."""
    soil = SimpleNamespace(type="soil", exponent=0.7)
    assert dimension(soil, "cohesive") == pytest.approx((1.0, -0.7, -2.0))
    assert dimension(soil, "frictional") == pytest.approx((1.0, -1.7, -2.0))


def test_masses_of_attracting_bodies_follow_the_order_of_the_bodies():
    scene = scenes.make("outer_solar_system")
    order = tuple(reversed(range(len(scene.bodies))))
    seen = image(scene, Placement(np.eye(3), np.zeros(3), order=order))
    before, after = ([load.gm for load in own.loads if isinstance(load, Newton)] for own in (scene, seen))
    assert after == [gm[::-1] for gm in before if gm]
    assert after


def test_one_force_that_varies_is_enough_whatever_stands_beside_it():
    steady = _pushed_along_its_own_axes(2)
    ramp = Table(times=(0.0, 1.0), values=(0.0, 1.0))
    (push,) = steady.loads
    for loads in ((push, push.model_copy(update={"name": "varied", "factor": ramp})),
                  (push.model_copy(update={"factor": ramp}), push.model_copy(update={"name": "other"}))):  # fmt: skip
        assert placement.cut_obstacle(steady.model_copy(update={"loads": loads}), back=False) == (
            "signals are not carried over a cut")  # fmt: skip


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_vectors_along_a_bodys_own_axes_are_inverted_or_reflected_by_a_mirror_and_torques_never(dimension, sense):
    """Axes of a mirrored body are inverted in space, and reflected at its x axis in the plane."""
    image = Placement(np.diag([1.0] * (dimension - 1) + [sense]), np.zeros(dimension))
    value = np.array([1.0, 2.0, 3.0][:dimension])
    mirrored = -value if dimension == 3 else np.array([1.0, -2.0])
    seen = {what: placement._in_body_axes(value, what, image) for what in ("polar", "axial")}
    assert seen == {"polar": tuple(value if sense > 0.0 else mirrored), "axial": tuple(value)}


def test_what_may_take_energy_keeps_a_scene_from_running_back():
    """A damper and a force from outside are named; a spring alone, and a run onwards, are not."""
    ends: dict[str, Any] = {"body_a": "ground", "body_b": "a", "point_a": (0.0, 0.0), "point_b": (1.0, 0.0)}
    spring = SpringDamper(name="spring", stiffness=5.0, damping=0.0, **ends)
    damper = spring.model_copy(update={"name": "damper", "damping": 0.3})
    push = Force(name="push", body="a", point=(1.0, 0.0), vector=(1.0, 0.0))
    body = PlanarBody(name="a", mass=1.0, inertia=1.0, position=(1.0, 0.0))
    scene = Scene(name="x", bodies=(body,), loads=(spring, damper, push), gravity=(0.0, 0.0), duration=1.0)
    assert cut_obstacle(scene, back=True) == "damper, push may take energy"
    assert cut_obstacle(scene, back=False) == ""
    assert cut_obstacle(scene.model_copy(update={"loads": (spring,)}), back=True) == ""
