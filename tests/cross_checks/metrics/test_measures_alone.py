"""Each measure on numbers whose measure is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cross_checks.metrics import drifts
from cross_checks.metrics.drifts import worst_joint
from cross_checks.metrics.errors import reaction_error
from cross_checks.metrics.metric import Absent
from mbs_ref import scenes
from mbs_ref.observables.distance import relative
from mbs_ref.observables.energy import EnergyBalance
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

FORCES = np.zeros((4, 3))


@pytest.mark.parametrize("off", [1e-3, -1e-3])
def test_the_worst_joint_is_the_one_broken_most_at_any_time(off):
    scene = scenes.make("double_pendulum")
    run = simulate(scene, Settings(t_end=0.1, samples=5))
    position = run.position.copy()
    position[2, 1] += (off, 0.0)  # the second rod, at one sample
    assert worst_joint(scene, replace(run, position=position)) == (scene.joints[1].name, pytest.approx(1e-3, rel=1e-6))


def test_a_run_that_blew_up_is_infinitely_far_and_nobody_warns():
    scene = scenes.make("double_pendulum")
    run = simulate(scene, Settings(t_end=0.1, samples=5))
    velocity = run.velocity.copy()
    velocity[3] = 1e300
    velocity[4] = -np.inf
    found = relative(scene, replace(run, velocity=velocity), run)
    assert np.isinf(found[3:, 2]).all()
    assert not found[:3].any()


def test_reactions_are_compared_over_what_both_report():
    off = FORCES.copy()
    off[1] = (0.0, -3.0, 1.0)
    assert reaction_error({"a": FORCES, "b": off}, {"a": FORCES, "b": FORCES, "c": off}) == 3.0
    assert reaction_error({"a": off}, {"a": FORCES[:2]}) == 3.0
    assert reaction_error({"a": off[:3]}, {"a": FORCES}) == 3.0
    assert reaction_error({"a": FORCES}, {"b": FORCES}) is None
    assert reaction_error({"a": FORCES, "b": np.full((4, 3), np.nan)}, {"a": FORCES, "b": FORCES}) is None


@pytest.mark.parametrize(("resolution", "known"), [(1e-7, True), (1e-5, False)])
def test_a_drift_is_told_where_the_work_is_known_to_a_billionth_of_the_energy(monkeypatch, resolution, known):
    balance = EnergyBalance(np.array([1e3, -2e3]), None, np.array([0.0, 1e-12]), resolution)
    monkeypatch.setattr(drifts, "energy_balance", lambda scene, run: balance)
    drift = drifts.energy_drift(None, None)  # type: ignore[arg-type]
    assert isinstance(drift, Absent) != known
    assert not isinstance(drift, Absent) or drift.reason
