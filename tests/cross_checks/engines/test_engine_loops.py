"""The N-four-bar A02 through its singular poses: what each engine is known to do there, shown."""

from __future__ import annotations

import numpy as np
import pytest

from mbs_ref import scenes
from mbs_ref.observables import constraint_residual, kinetic_energy, potential_energy
from mbs_ref.trajectory import Status
from tests.cross_checks.engines.engine_runs import engine, run

B0_END = np.array([0.328458111539739, 0.944518538178975])  # m, at t = 10 s, one-degree-of-freedom solution
FOUR_BAR = scenes.make("n_four_bar", loops=2)


def tip_error(result) -> float:
    """Return the distance (m) of B0 from the truth; the crank's centre is half way to it."""
    return float(np.linalg.norm(2.0 * result.position[-1, 0] - B0_END))


def energy_change(result) -> float:
    total = kinetic_energy(FOUR_BAR, result) + potential_energy(FOUR_BAR, result)
    return float(total[-1] - total[0])


def test_pinocchio_with_gains_passes():
    result = run("pinocchio", "rk4", FOUR_BAR, samples=11)
    assert result.ok
    assert abs(energy_change(result)) < 1e-8
    assert np.abs(constraint_residual(FOUR_BAR, result)).max() < 1e-11
    assert tip_error(result) < 1e-9


def test_pinocchio_without_gains_leaves_the_manifold():
    result = run("pinocchio", "rk4_no_gains", FOUR_BAR, samples=11)
    assert np.abs(constraint_residual(FOUR_BAR, result)).max() > 1e-2
    assert abs(energy_change(result)) > 5.0
    assert engine("pinocchio").method("rk4_no_gains").wrong_limit


def test_pinocchio_under_adaptive_steps_loses_the_energy_at_a_singular_pose():
    """Steps shrink towards the pose and land on it; fixed steps jump over it. Rounding lets a run in five jump, too."""
    runs = [run("pinocchio", "dop853", FOUR_BAR, rtol=rtol, samples=11) for rtol in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)]
    assert np.median([energy_change(result) for result in runs]) < -1.0
    assert engine("pinocchio").method("dop853").wrong_limit


def test_mujoco_default_solref_converges_to_a_wrong_limit():
    results = [run("mujoco", "rk4", FOUR_BAR, step=h, samples=11) for h in (2.5e-3, 1e-3)]
    losses = [energy_change(result) for result in results]
    assert losses[0] == pytest.approx(losses[1], rel=1e-3)
    assert losses[1] < -1.0
    assert all(tip_error(result) > 0.5 for result in results)
    assert engine("mujoco").method("rk4").wrong_limit


def test_mujoco_tight_solref_converges_to_the_truth():
    results = [run("mujoco", "rk4_tight", FOUR_BAR, step=h, samples=11) for h in (2e-3, 1e-3, 5e-4)]
    errors = [tip_error(result) for result in results]
    assert errors[0] > 1.9 * errors[1] > 3.6 * errors[2]
    assert abs(energy_change(results[2])) < 1e-2


def test_exudyn_generalized_alpha_passes_and_the_trapezoidal_rule_with_halved_steps_too():
    good = run("exudyn", "generalized_alpha", FOUR_BAR, step=2.5e-3, samples=11)
    assert good.ok
    assert tip_error(good) < 1e-3
    halved = run("exudyn", "trapezoidal", FOUR_BAR, step=1e-3, samples=101)
    assert any("steps that may be halved began anew" in note for note in halved.notes)
    assert tip_error(halved) < 1e-3


@pytest.mark.slow
def test_exudyns_trapezoidal_rule_does_not_pass_everywhere():
    stopped = run("exudyn", "trapezoidal", FOUR_BAR, step=2.5e-4, samples=101)
    assert stopped.status is Status.NOT_CONVERGED
    assert "t = " in stopped.message
    assert 0 < len(stopped.times) < 101
    assert np.abs(constraint_residual(FOUR_BAR, stopped)).max() < 1e-3


def test_a_kinematic_tree_refuses_every_loop_by_name():
    method = engine("exudyn").method("tree_rk44")
    reasons = [refusal.reason for refusal in engine("exudyn").method_refusals(FOUR_BAR, method)]
    assert len([r for r in reasons if "closes a loop" in r]) == 2


def test_a_documented_weakness_names_the_causes_that_the_scene_has():
    rk4 = engine("mujoco").method("rk4")
    loop, slide = rk4.exemption(FOUR_BAR), rk4.exemption(scenes.make("rocking_block"))
    assert "loop closures" in loop
    assert "friction" not in loop
    assert slide == "friction raises the normal force of a contact that slides"
