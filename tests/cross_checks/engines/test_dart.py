"""DART: symplectic Euler on trees, loops and loads, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.conformance.symmetry.placement import Placement, image
from cross_checks.judge.one_run import evaluate
from mbs_ref import scenes
from mbs_ref.observables import constraint_residual
from mbs_ref.scene import Scene
from mbs_ref.settings import Settings
from tests.cross_checks.engines.engine_runs import distance, engine, observed_order, run

EULER = "symplectic_euler"


@pytest.fixture(autouse=True)
def dart():
    return engine("dart")


@pytest.mark.parametrize(
    "name",
    ["pendulum", "double_pendulum", "n_four_bar", "spatial_n_four_bar", "spring_pendulum", "torque_free_top",
     "spatial_chain"],
)  # fmt: skip
def test_the_order_shows(name):
    assert observed_order(errors_of(name)) == pytest.approx(1.0, abs=0.25)


def errors_of(name: str) -> list[float]:
    """Return the errors at a step and at half of it."""
    errors = []
    for step in (2.5e-3, 1.25e-3):
        record = evaluate(scenes.make(name), "dart", Settings(method=EULER, step=step, t_end=0.3, samples=4))
        assert record.status == "success", record.message
        errors.append(record.error.value)
    return errors


def test_a_ball_bounces_by_the_shared_force():
    coarse, fine = errors_of("bouncing_ball")
    assert fine < 0.8 * coarse < 2e-2


def test_loops_stay_closed_as_the_step_shrinks():
    scene = scenes.make("n_four_bar", loops=1)
    gaps = [
        np.abs(constraint_residual(scene, run("dart", EULER, scene, step=h, t_end=0.3))).max() for h in (3e-3, 1e-3)
    ]
    assert gaps[1] < 1e-6  # m
    assert gaps[1] < gaps[0] / 3.0


def tilted() -> Scene:
    """Return the four-bar turned by 0.7 rad about x."""
    c, s = np.cos(0.7), np.sin(0.7)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return image(scenes.make("spatial_n_four_bar", loops=1), Placement(about_x, np.zeros(3)))


@pytest.mark.parametrize(
    ("scene", "metres"),
    [(scenes.make("spatial_n_four_bar", loops=1), 1e-6), (tilted(), 1e-6), (scenes.make("bricard"), 1e-4)],
    ids=["plain", "tilted", "bricard"],
)
def test_loops_hold_whatever_way_their_axes_stand(scene, metres):
    path = run("dart", EULER, scene, step=1e-3, t_end=0.3)
    assert np.abs(constraint_residual(scene, path)).max() < metres


def test_darts_own_hinge_lets_tilted_loops_go():
    """Once it holds them, the method is no longer worth its place."""
    gaps = [
        np.abs(
            constraint_residual(scene, run("dart", "symplectic_euler_own_hinge", scene, step=1e-3, t_end=0.03))
        ).max()
        for scene in (scenes.make("spatial_n_four_bar", loops=1), tilted())
    ]
    assert gaps[0] < 1e-6
    assert gaps[1] > 0.5


def test_named_schemes_give_the_same_numbers():
    """DART's only scheme is what MuJoCo calls Euler."""
    scene = scenes.make("double_pendulum")
    ours, theirs = (run(*pair, scene, step=1e-3, t_end=0.3) for pair in (("dart", EULER), ("mujoco", "euler")))
    assert distance(ours, theirs) < 1e-9


def test_refusals_name_the_part(dart):
    (refusal,) = dart.refusals(scenes.make("spherical_pendulum"))
    assert refusal.reason == "joint 'rod' closes a loop as rod, which dart does not implement"
    assert "rigid_law" in dart.refusals(scenes.make("newtons_cradle"))[0].reason
