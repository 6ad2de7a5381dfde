"""The contact problem of one instant against a ball whose motion on a slope is known, and what violates it."""

import math

import numpy as np
import pytest

from cross_checks.contact.instant import instant, violation, write
from mbs_ref import scenes
from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.contact import SphereOnPlane, SpringDamperLaw, StickSlip

G, STEP, MASS, FRICTION = 9.81, 1e-3, 2.0, 0.5


def _point_on_slope(angle: float) -> Scene:
    """A ball that its inertia keeps from turning, at rest on a slope along x; its radius is 0.1 m."""
    ball = SpatialBody(name="ball", mass=MASS, inertia=(1e9, 1e9, 1e9, 0.0, 0.0, 0.0), position=(0.0, 0.0, 0.1))
    floor = SphereOnPlane(name="floor", body_a="ball", center=(0.0, 0.0, 0.1), radius=0.1, point=(0.0, 0.0, 0.0),
                          normal=(0.0, 0.0, 1.0), law=SpringDamperLaw(stiffness=1e5),
                          friction=StickSlip(coefficient=FRICTION, stiffness=1e5))  # fmt: skip
    gravity = (G * math.sin(angle), 0.0, -G * math.cos(angle))
    return Scene(name="slope", gravity=gravity, bodies=(ball,), contacts=(floor,))


def test_a_ball_on_a_slope_has_the_delassus_matrix_and_free_velocity_of_a_point():
    problem = instant(_point_on_slope(0.2), STEP)
    assert problem.delassus == pytest.approx(np.eye(3) / MASS, abs=1e-9)
    assert problem.free[0] == pytest.approx(-STEP * G * math.cos(0.2), rel=1e-12)
    assert np.linalg.norm(problem.free[1:]) == pytest.approx(STEP * G * math.sin(0.2), rel=1e-12)


def test_rest_solves_the_problem_inside_the_cone_and_not_outside():
    held = violation(instant(_point_on_slope(0.2), STEP), np.zeros(3))
    assert [held.penetrating, held.pushing_apart, held.not_opposed] == pytest.approx([0.0] * 3, abs=1e-12)
    assert held.unexplained == pytest.approx(0.0, abs=1e-10)
    beyond = violation(instant(_point_on_slope(1.0), STEP), np.zeros(3))
    assert beyond.unexplained > 1e-3  # no friction inside the cone holds it


def test_what_slides_or_creeps_violates_only_what_it_should():
    problem = instant(_point_on_slope(1.0), STEP)
    along = problem.free[1:] / np.linalg.norm(problem.free[1:])
    slides = STEP * G * (math.sin(1.0) - FRICTION * math.cos(1.0))
    solved = violation(problem, np.concatenate(([0.0], slides * along)))
    assert [solved.not_opposed, solved.unexplained] == pytest.approx([0.0, 0.0], abs=1e-10)
    gentle = instant(_point_on_slope(0.2), STEP)
    creep = 1e-5 * gentle.free[1:] / np.linalg.norm(gentle.free[1:])
    creeps = violation(gentle, np.concatenate(([0.0], creep)))
    missing = FRICTION * math.cos(0.2) - math.sin(0.2)  # of the full force, m g h of it
    assert creeps.not_opposed == pytest.approx(1e-5 * MASS * G * STEP * missing, rel=1e-2)
    lifted = violation(gentle, np.concatenate(([0.01], np.zeros(2))))
    assert lifted.pushing_apart == pytest.approx(0.01 * MASS * (0.01 + STEP * G * math.cos(0.2)), rel=1e-6)


def test_a_written_problem_has_fclibs_names(tmp_path):
    problem = instant(scenes.make("incline"), STEP)
    write(problem, tmp_path / "incline.npz")
    found = {name.removeprefix("fclib_local/"): values for name, values in np.load(tmp_path / "incline.npz").items()}
    assert {"spacedim", "vectors/q", "vectors/mu", "W/m", "W/n", "W/nzmax", "W/nz", "W/p", "W/i", "W/x"} == set(found)
    assert found["W/m"] == found["W/n"] == len(found["vectors/q"]) == 2 * len(found["vectors/mu"])
    assert found["W/nz"] == -1  # compressed columns
    assert problem.contacts == ("corner.left", "corner.right")  # the upper ones are far away


def test_a_scene_in_which_nothing_touches_is_refused():
    with pytest.raises(ValueError, match="bouncing_ball: no contact touches"):
        instant(scenes.make("bouncing_ball"), STEP)
