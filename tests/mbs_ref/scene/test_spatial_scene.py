"""What a spatial scene refuses, and how it says so."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from mbs_ref.scene import PlanarBody, PointMass, Revolute, Scene, SpatialBody, Spherical, Torque, TorqueVector, Weld
from mbs_ref.scene.euler_parameters import (
    conjugate,
    from_axis_angle,
    from_matrix,
    product,
    rotated,
    rotation_matrices,
    rotation_vector,
    turn_size,
)
from mbs_ref.settings import Settings
from mbs_ref.simulate import InconsistentScene, simulate

SOLID = (1.0, 2.0, 2.5, 0.0, 0.0, 0.0)  # kg m^2


def body(**more) -> SpatialBody:
    return SpatialBody(**({"name": "b", "mass": 1.0, "inertia": SOLID} | more))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"orientation": (1.0, 0.1, 0.0, 0.0)}, ["orientation", "norm 1.00498"]),
        ({"orientation": (0.0, 0.0, 0.0, 0.0)}, ["orientation", "norm 0"]),
        ({"inertia": (1e-12, 1.0, 1.0, 0.0, 0.0, 0.0)}, ["principal moments", "1e-12", "1e-09"]),
        ({"inertia": (0.0, 1.0, 1.0, 0.0, 0.0, 0.0)}, ["principal moments 0"]),
        ({"inertia": (1.0, 1.0, 5.0, 0.0, 0.0, 0.0)}, ["exceeds the sum"]),
        ({"inertia": ((1.0, 0.1, 0.0), (0.2, 1.0, 0.0), (0.0, 0.0, 1.0))}, ["symmetric"]),
        ({"mass": 0.0}, ["mass"]),
    ],
)
def test_a_body_that_cannot_be_is_refused(fields, words):
    with pytest.raises(ValidationError) as caught:
        body(**fields)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_scene_in_space_needs_no_gravity():
    assert Scene(name="free", bodies=(body(),)).gravity == (0.0, 0.0, 0.0)
    assert Scene(name="flat", bodies=(PlanarBody(name="b", mass=1.0, inertia=1.0),)).gravity == (0.0, 0.0)
    with pytest.raises(ValidationError, match="3 components"):
        Scene(name="free", bodies=(body(),), gravity=(0.0, 0.0))


def test_inertia_as_six_numbers_or_as_a_matrix():
    matrix = ((1.0, 0.1, 0.2), (0.1, 2.0, 0.3), (0.2, 0.3, 2.5))
    assert body(inertia=matrix).inertia == (1.0, 2.0, 2.5, 0.1, 0.2, 0.3)
    assert body(inertia=matrix).inertia_matrix.tolist() == [list(row) for row in matrix]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"joints": (Revolute(name="j", body_a="ground", body_b="b", point=(0.0, 0.0, 0.0)),)}, "needs an axis"),
        ({"loads": (Torque(name="t", body="b", torque=1.0),)}, "use torque_vector"),
        ({"joints": (Weld(name="j", body_a="b", body_b="p", point=(0.0, 0.0, 0.0)),)}, "no orientation"),
        ({"gravity": (0.0, -9.81)}, "gravity"),
    ],
)
def test_what_makes_no_sense_in_space(parts, words):
    particle = PointMass(name="p", mass=1.0, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0))
    with pytest.raises(ValidationError, match=words):
        Scene(**({"name": "s", "gravity": (0.0, 0.0, 0.0), "bodies": (body(), particle)} | parts))


def test_what_makes_no_sense_in_the_plane():
    flat = PlanarBody(name="b", mass=1.0, inertia=1.0)
    ball = Spherical(name="j", body_a="ground", body_b="b", point=(0.0, 0.0, 0.0))
    twist = TorqueVector(name="t", body="b", vector=(0.0, 0.0, 1.0))
    with pytest.raises(ValidationError) as caught:
        Scene(name="s", bodies=(flat,), joints=(ball,), loads=(twist,))
    assert "spherical is for space alone" in str(caught.value)
    assert "torque_vector is for space alone" in str(caught.value)


def test_an_inconsistent_start_names_the_joint():
    ball = Spherical(name="ball", body_a="ground", body_b="b", point=(1.0, 0.0, 0.0))
    scene = Scene(name="s", gravity=(0.0, 0.0, 0.0), bodies=(body(velocity=(0.0, 1.0, 0.0)),), joints=(ball,))
    with pytest.raises(InconsistentScene, match="joint 'ball': velocity gap 1"):
        simulate(scene, Settings(t_end=0.1, estimate="off"))


def test_near_zero_inertia_about_one_axis_is_right():
    """A needle spun about its own axis keeps spinning while it turns over: J1 w1 is conserved for J2 = J3."""
    needle = body(inertia=(2e-9, 1.0, 1.0, 0.0, 0.0, 0.0), angular_velocity=(5.0, 1.0, 0.0))
    path = simulate(Scene(name="s", gravity=(0.0, 0.0, 0.0), bodies=(needle,)), Settings(rtol=1e-10, t_end=10.0))
    axis = rotation_matrices(path.orientation[:, 0])[:, :, 0]
    assert np.sum(axis * path.angular_velocity[:, 0], axis=1) == pytest.approx(5.0, abs=1e-6)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9])
def test_orientations_where_three_angles_lock_are_like_any_other(pitch):
    """The same motion, seen in turned axes: Euler parameters know no gimbal lock."""
    tilt = product(from_axis_angle((0.0, 0.0, 1.0), 0.3), from_axis_angle((0.0, 1.0, 0.0), pitch))
    omega = np.array([0.3, 2.0, 0.1])
    settings = Settings(rtol=1e-12, t_end=5.0)

    def run(theta):
        spin = tuple((rotation_matrices(theta) @ omega).tolist())
        moved = body(orientation=tuple(theta.tolist()), angular_velocity=spin)
        return simulate(Scene(name="s", gravity=(0.0, 0.0, 0.0), bodies=(moved,)), settings).orientation[-1, 0]

    plain = run(np.array([1.0, 0.0, 0.0, 0.0]))
    between = product(run(tilt), conjugate(product(tilt, plain)))
    assert np.linalg.norm(rotation_vector(between)) < 1e-10  # rad


def test_turns_about_many_axes_are_each_about_its_own():
    axes, angles = np.array([[2.0, 0.0, 0.0], [0.0, 0.0, -0.5]]), np.array([0.4, 1.1])
    each = [from_axis_angle(axis, angle) for axis, angle in zip(axes, angles, strict=True)]
    assert from_axis_angle(axes, angles) == pytest.approx(np.array(each), abs=1e-15)
    assert each[0] == pytest.approx([np.cos(0.2), np.sin(0.2), 0.0, 0.0], abs=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_matrices_and_parameters_are_inverse(seed):
    theta = np.random.default_rng(seed).standard_normal(4)
    theta /= np.linalg.norm(theta)
    between = product(from_matrix(rotation_matrices(theta)), conjugate(theta))
    assert np.linalg.norm(rotation_vector(between)) < 1e-14


def test_a_turned_vector_is_that_of_the_matrix_and_a_turn_has_the_size_of_its_vector():
    rng = np.random.default_rng(0)
    theta, vectors = 3.0 * rng.standard_normal((4, 5, 4)), rng.standard_normal((5, 3))  # of any length
    expected = np.einsum("...ij,...j->...i", rotation_matrices(theta), np.broadcast_to(vectors, (4, 5, 3)))
    np.testing.assert_allclose(rotated(theta, vectors), expected, atol=1e-14)
    np.testing.assert_allclose(turn_size(theta), np.linalg.norm(rotation_vector(theta), axis=-1), atol=1e-14)
    assert turn_size(from_axis_angle([0.0, 0.0, 1.0], [0.3, -0.3, np.pi, 6.0])) == pytest.approx(
        [0.3, 0.3, np.pi, 2.0 * np.pi - 6.0]
    )
