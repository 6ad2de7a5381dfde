"""The contact problem of one instant against a ball whose motion on a slope is known, and what violates it."""

import math

import numpy as np
import pytest

from cross_checks.contact import model_of
from cross_checks.contact.by_figure import holding
from cross_checks.contact.instant import (
    Instant,
    assess,
    instant,
    natural_residual,
    nearest_impulses,
    state_at,
    violation,
    write,
)
from cross_checks.engine import Plan
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


def test_only_the_exact_impulse_of_a_block_has_no_natural_residual():
    """A block that slides has r_N = m g h cos(a) and mu r_N against its motion; W = 1/m."""
    problem = instant(_point_on_slope(1.0), STEP)
    normal = MASS * STEP * G * math.cos(1.0)
    along = problem.free[1:] / np.linalg.norm(problem.free[1:])
    exact = np.concatenate(([normal], -FRICTION * normal * along))
    assert natural_residual(problem, exact) < 1e-15
    lifts = 0.01 * normal / MASS  # u_N of a hundredth more, of which the cone's projection leaves 1/(1 + mu^2)
    assert natural_residual(problem, 1.01 * exact) == pytest.approx(lifts / (1.0 + FRICTION**2), rel=1e-9)
    assert natural_residual(problem, exact * [1.0, 0.9, 0.9]) > 0.01 * normal / MASS


def _of_mujoco(problem: Instant, method: str):
    """Return MuJoCo's W = J M^-1 J^T in its own frames, and its impulses of a step (n_contacts, 3)."""
    mujoco = pytest.importorskip("mujoco")
    engine = model_of("mujoco").engine
    built = engine.build(problem.scene, Plan(engine.method(method), np.array((0.0, problem.step)), problem.step))
    mujoco.mj_step1(built.model, built.data)
    mujoco.mj_forward(built.model, built.data)
    rows = built.data.efc_J.reshape(-1, built.model.nv)
    solved = np.empty_like(rows)
    mujoco.mj_solveM(built.model, built.data, solved, rows)
    return rows @ solved.T, built.data.efc_force.reshape(-1, 3) * problem.step


def test_the_delassus_matrix_of_jaws_and_a_stack_is_mujocos():
    """Tangents may be turned within each contact, which changes neither eigenvalues nor the normals' block."""
    for name in ("gripped by two jaws", "slope beneath 1 of its mass"):
        problem = instant(holding()[name], STEP)
        theirs, _ = _of_mujoco(problem, "euler")
        scale = np.abs(theirs).max()
        assert len(problem.contacts) == 8
        assert np.linalg.eigvalsh(problem.delassus) == pytest.approx(np.linalg.eigvalsh(theirs), abs=1e-6 * scale)
        assert problem.delassus[::3, ::3] == pytest.approx(theirs[::3, ::3], abs=1e-6 * scale)


def test_the_impulses_nearest_to_a_step_of_mujoco_are_those_it_computed():
    pytest.importorskip("mujoco")
    problem = instant(_point_on_slope(0.2), STEP)
    _, impulses = _of_mujoco(problem, "stock_impratio10")
    (found,) = [one for one in assess(problem, [model_of("mujoco")]) if one.method == "stock_impratio10"]
    u = problem.free + problem.delassus @ np.concatenate(([impulses[0, 0]], _turned(problem, impulses[0])))
    ours = nearest_impulses(problem, u)
    assert ours[0] == pytest.approx(impulses[0, 0], rel=1e-9)
    assert found.residual == pytest.approx(natural_residual(problem, ours), rel=1e-6)
    assert found.unexplained < 1e-12


def _turned(problem: Instant, impulse: np.ndarray) -> np.ndarray:
    """Return the tangential impulse in our frame: it opposes the free velocity."""
    return -np.linalg.norm(impulse[1:]) * problem.free[1:] / np.linalg.norm(problem.free[1:])


def test_the_state_at_a_time_is_that_of_a_block_that_coulomb_brakes():
    block = scenes.make("sliding_block", height=0.0)
    speed = block.bodies[0].velocity[0]
    mu = block.contacts[0].friction.coefficient
    later = state_at(block, 0.3)
    assert later.bodies[0].velocity[0] == pytest.approx(speed - mu * 9.81 * 0.3, rel=1e-3)
    problem = instant(later, STEP)
    (ours,) = assess(problem, [])
    assert (ours.engine, ours.reason) == ("mbs_ref", "")
    assert ours.residual < 1e-9  # its weight is in balance, and friction has its full force
    assert problem.free[1] ** 2 == pytest.approx(later.bodies[0].velocity[0] ** 2, rel=1e-9)


def test_a_later_state_of_a_driven_scene_is_refused():
    with pytest.raises(ValueError, match=r"ball_on_driven_seat: its signals would begin anew at t = 0.1 s"):
        state_at(scenes.make("ball_on_driven_seat"), 0.1)
