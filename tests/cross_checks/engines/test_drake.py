"""Drake: orders, loops and refusals; and the constraint that ends its process costs that run alone."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.conformance.probes import probes
from cross_checks.judge.one_run import evaluate
from mbs_ref import scenes
from mbs_ref.observables import constraint_residual
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Status
from tests.cross_checks.engines.engine_runs import distance, engine, observed_order, run

FOUR_BAR = scenes.make("n_four_bar", loops=1)


@pytest.fixture(autouse=True)
def drake():
    return engine("drake")


def error_of(scene, method: str, **accuracy) -> float:
    """Return the error against the scene's truth over a third of a second."""
    record = evaluate(scene, "drake", Settings(method=method, t_end=0.3, samples=4, **accuracy))
    assert record.status == "success", record.message
    return record.error.value


@pytest.mark.parametrize("name", ["double_pendulum", "torque_free_top", "spatial_chain"])
@pytest.mark.parametrize(("method", "order"), [("runge_kutta3_fixed", 3), ("runge_kutta2_fixed", 2), ("sap", 1)])
def test_the_order_shows_on_trees(name, method, order):
    errors = [error_of(scenes.make(name), method, step=step) for step in (2.5e-3, 1.25e-3)]
    assert observed_order(errors) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("name", ["pendulum", "double_pendulum", "heavy_top", "bouncing_ball"])
def test_error_control_follows_the_accuracy(name):
    assert error_of(scenes.make(name), "runge_kutta3", rtol=1e-10) < 1e-8


@pytest.mark.parametrize("scene", [FOUR_BAR, scenes.make("spatial_n_four_bar", loops=1)], ids=["planar", "spatial"])
def test_loops_converge_in_discrete_time_and_refuse_in_continuous(drake, scene):
    errors = [error_of(scene, "sap", step=step) for step in (2.5e-3, 1.25e-3)]
    assert observed_order(errors) == pytest.approx(1.0, abs=0.2)
    path = run("drake", "sap", scene, step=1e-3, t_end=0.3)
    assert np.abs(constraint_residual(scene, path)).max() < 1e-4
    (refusal,) = drake.method_refusals(scene, drake.method("runge_kutta3"))
    assert refusal.reason == "runge_kutta3 cannot model a scene that is closed-loop"


def test_rods_between_bodies_are_left_to_discrete_time(drake):
    """They are constraints, though no loop is closed: the plant died of them in continuous time."""
    scene = probes()["distance", 2]
    refusals = [refusal.reason for refusal in drake.method_refusals(scene, drake.method("runge_kutta5"))]
    kept = "is a constraint, which Drake keeps in discrete time alone"
    assert refusals == [f"runge_kutta5: joint {name!r} {kept}" for name in ("one", "two")]
    assert drake.method_refusals(scene, drake.method("sap")) == []


def test_cenic_closes_loops_under_error_control():
    coarse, fine = (error_of(FOUR_BAR, "cenic", rtol=rtol) for rtol in (1e-4, 1e-6))
    assert fine < 1e-2
    assert observed_order([coarse, fine], ratio=100.0) == pytest.approx(0.5, abs=0.25)  # first order: twice as exact


def test_named_schemes_give_the_same_numbers():
    """Drake's discrete plant without contact is symplectic Euler, and so is MuJoCo's Euler."""
    scene = scenes.make("double_pendulum")
    ours, theirs = (run(*pair, scene, step=1e-3, t_end=0.3) for pair in (("drake", "sap"), ("mujoco", "euler")))
    assert distance(ours, theirs) < 1e-9


def test_a_constraint_at_the_world_itself_costs_its_own_run_alone():
    """Drake 1.58 ends the process there; where it no longer does, the method has nothing left to show."""
    scene = scenes.make("spherical_pendulum")
    path = run("drake", "sap_world", scene, step=1e-3, t_end=0.01)
    assert path.status is Status.ENGINE_ERROR
    assert path.message == "drake did not come back: its process was ended by SIGSEGV"
    anchored = run("drake", "sap", scene, step=1e-3, t_end=0.01)
    assert anchored.ok
    assert "welded to the world" in " ".join(anchored.notes)


def test_refusals_name_the_part(drake):
    reasons = [refusal.reason for refusal in drake.refusals(scenes.make("incline"))]
    assert "drake does not implement the part type 'stick_slip'" in reasons
    assert "sap_world differs only where a loop is closed at ground, and none is" in [
        refusal.reason for refusal in drake.method_refusals(FOUR_BAR, drake.method("sap_world"))
    ]
