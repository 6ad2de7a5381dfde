"""The androids' truths: certified, obeyed by joints, and met by the solver, which shares no code with them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.androids import IMPACTS, NAMES, convergence
from cross_checks import ladder
from cross_checks.truths import Truth, seek_truth
from mbs_ref import scenes
from mbs_ref.observables import constraint_residual
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory

certified = 1e-10  # m
met = 1e-8  # m, at rtol 1e-9
converged = 1e-6  # m
kept = 1e-9  # m, |C|


def truth_of(scene) -> Truth:
    found = seek_truth(scene, ladder.grid(scene))
    assert isinstance(found, Truth), found
    assert found.uncertainty < certified
    return found


@pytest.mark.parametrize(
    "parameters",
    [{}, {"impact": "rear"}, {"law": "spring_damper"}, {"seat": "driven"}, {"pulse": "table"}, {"lift": 0.05}],
    ids=str,
)
def test_the_solver_meets_the_truth(parameters):
    scene = scenes.make("android_simplified", **parameters)
    truth = truth_of(scene)
    found = simulate(scene, Settings(rtol=1e-9, reactions=False), ladder.grid(scene))
    assert np.abs(found.position - truth.position).max() < met
    assert np.abs(found.orientation - truth.angle).max() < 10 * met
    still = np.zeros_like(truth.position)
    path = Trajectory(ladder.grid(scene), truth.position, truth.angle, still, truth.angle * 0.0)
    assert np.abs(constraint_residual(scene, path)).max() < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize("impact", IMPACTS)
def test_the_solver_meets_the_vertebral_truth(impact):
    """Half a minute: the truth of a stiff chain by explicit methods."""
    scene = scenes.make("android_vertebral", impact=impact)
    found = simulate(scene, Settings(rtol=1e-9, reactions=False), ladder.grid(scene))
    assert np.abs(found.position - truth_of(scene).position).max() < met


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("impact", IMPACTS)
def test_head_and_hip_converge_by_two_unlike_integrators(name, impact):
    found = convergence(name, impact)
    assert max(gap.max() for gap in found.gaps.values()) < converged
    assert max(found.compliance.values()) < kept
    assert found.error is not None
    assert found.error < converged
