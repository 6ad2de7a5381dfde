"""The suspension unit on a shaker post against its closed form, which shares no code with the solver."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.truths import seek_truth
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate

TIMES = np.linspace(0.0, 2.0, 41)


def truth_of(scene) -> Truth:
    found = seek_truth(scene, TIMES)
    assert isinstance(found, Truth), found
    return found


@pytest.mark.parametrize("parameters", [{}, {"frequency": 20.0, "damping": 0.0}, {"amplitude": 0.1, "gravity": 0.0}])
def test_the_solver_meets_the_closed_form(parameters):
    scene = scenes.make("suspension_rig", **parameters)
    truth, run = truth_of(scene), simulate(scene, Settings(rtol=1e-12, reactions=False, estimate="off"), TIMES)
    assert run.ok, run.message
    assert np.abs(run.position - truth.position).max() < 1e-11
    assert truth.velocity is not None
    assert np.abs(run.velocity - truth.velocity).max() < 1e-9


def test_a_slow_post_carries_the_hull_along_and_a_fast_one_hardly_moves_it():
    slow, fast = (truth_of(scenes.make("suspension_rig", frequency=f, damping=2e4)) for f in (0.05, 50.0))
    rise = [truth.position[:, 2, 1] - truth.position[0, 2, 1] for truth in (slow, fast)]
    post = slow.position[:, 0, 1] - slow.position[0, 0, 1]
    assert rise[0] == pytest.approx(post, abs=0.001)
    assert np.ptp(rise[1][20:]) < 0.004  # m, where the post moves by 0.04 m
