"""MJX against MuJoCo and the truth, in double precision."""

from __future__ import annotations

import pytest

from cross_checks.judge.one_run import evaluate
from mbs_ref import scenes
from mbs_ref.settings import Settings
from tests.cross_checks.engines.engine_runs import distance, engine, observed_order, run


@pytest.fixture(autouse=True)
def mjx():
    return engine("mjx")


def test_named_schemes_give_the_same_numbers_in_double_precision():
    scene = scenes.make("double_pendulum")
    ours, theirs = (run(name, "euler", scene, step=1e-3, t_end=0.3) for name in ("mjx", "mujoco"))
    assert ours.ok, ours.message
    assert distance(ours, theirs) < 1e-12  # m; single precision leaves 1e-6


@pytest.mark.slow  # each model compiles for seconds
@pytest.mark.parametrize("name", ["n_four_bar", "spring_pendulum", "spherical_pendulum"])
def test_loops_springs_and_rods_follow_mujoco(name):
    scene = scenes.make(name)
    ours, theirs = (run(engine, "euler", scene, step=1e-3, t_end=0.1) for engine in ("mjx", "mujoco"))
    assert ours.ok, ours.message
    assert distance(ours, theirs) < 1e-5  # m, of soft constraints that each solves in its own way


@pytest.mark.slow
@pytest.mark.parametrize(
    "scene",
    [scenes.make("bouncing_sphere", law="spring_damper_force", height=0.1003), scenes.make("rolling_sphere")],
    ids=["without friction", "with friction"],
)
def test_contacts_of_bodies_free_in_space_follow_mujoco(scene):
    ours, theirs = (run(engine, "euler", scene, step=1e-3, t_end=0.3) for engine in ("mjx", "mujoco"))
    assert ours.ok, ours.message
    assert distance(ours, theirs) < 1e-6  # m


@pytest.mark.slow  # Runge-Kutta compiles for half a minute
@pytest.mark.parametrize(("name", "order"), [("double_pendulum", 4), ("torque_free_top", 2)])
def test_runge_kutta_has_order_two_where_bodies_turn_in_space(name, order):
    """MuJoCo's own keeps order 4 there; seen in MJX 3.17."""
    errors = []
    for step in (1e-2, 5e-3):
        record = evaluate(scenes.make(name), "mjx", Settings(method="rk4", step=step, t_end=0.3, samples=4))
        assert record.status == "success", record.message
        errors.append(record.error.value)
    assert observed_order(errors) == pytest.approx(order, abs=0.3)


def test_refusals_name_what_mjx_lacks(mjx):
    assert any("'progressive_law'" in r.reason for r in mjx.refusals(scenes.make("android_simplified")))
    disc = scenes.make("bouncing_ball", law="spring_damper_force")
    assert any("effective mass" in r.reason for r in mjx.refusals(disc))  # there MJX pushes 1.5 times as hard
    assert "implicit" not in [method.name for method in mjx.methods()]
