"""The androids' truths: certified, obeyed by joints, and met by the solver, which shares no code with them."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.judge import ladder
from cross_checks.truths import certificate, seek_truth, stored_poses
from cross_checks.truths.truth import Truth
from mbs_ref import scenes
from mbs_ref.observables import constraint_residual
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from mbs_ref.trajectory import Trajectory
from reports.facts.curves import Measured
from reports.studies.androids import add_convergence
from reports.studies.crash import IMPACTS, NAMES

BARE = {"model": "paper"}
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
    [
        {"impact": "rear", "seat": "driven"}, BARE | {"law": "spring_damper", "pulse": "table"},
        *(pytest.param(one, marks=pytest.mark.slow) for one in (
            {}, {"impact": "rear"}, {"seat": "driven"}, BARE, BARE | {"impact": "rear"}, BARE | {"lift": 0.05},
            BARE | {"law": "spring_damper"}, BARE | {"pulse": "table"})),
    ],
    ids=str,
)  # fmt: skip
def test_the_solver_meets_the_truth(parameters):
    scene = scenes.make("android_simplified", **parameters)
    truth = truth_of(scene)
    found = simulate(scene, Settings(rtol=1e-9, reactions=False, estimate="off"), ladder.grid(scene))
    assert np.abs(found.position - truth.position).max() < met
    assert np.abs(found.orientation - truth.orientation).max() < 10 * met
    still = np.zeros_like(truth.position)
    path = Trajectory(ladder.grid(scene), truth.position, truth.orientation, still, truth.orientation * 0.0)
    assert np.abs(constraint_residual(scene, path)).max() < 1e-14


@pytest.mark.parametrize("impact", IMPACTS)
def test_the_solver_meets_the_vertebral_truth(impact):
    scene = scenes.make("android_vertebral", impact=impact, **BARE)
    found = simulate(scene, Settings(rtol=1e-9, reactions=False, estimate="off"), ladder.grid(scene))
    assert np.abs(found.position - truth_of(scene).position).max() < met


@pytest.mark.slow
@pytest.mark.parametrize("impact", IMPACTS)
@pytest.mark.parametrize("name", NAMES)
def test_head_and_hip_converge_by_two_unlike_integrators(name, impact):
    row = add_convergence(Measured(), scenes.make(name, impact=impact, **BARE))
    assert max(row[part] for part in ("head", "hip", "error")) < converged
    assert max(row[method] for method in ("dop853", "radau")) < kept


def test_what_is_kept_on_disk_is_a_certified_truth_of_scenes_as_they_are():
    """A changed scene has another name there, so that nothing stale is read; `mbs-ref certify` makes them again."""
    certified_scenes = [scenes.make(kept.scene, **kept.parameters) for kept in certificate.every()]
    known = {stored_poses.file_of(scene) for scene in certified_scenes}
    files = set(stored_poses.FOLDER.glob("*.npz"))
    assert files <= known
    bare = [scenes.make("android_vertebral", impact=impact, **BARE) for impact in IMPACTS]
    assert {stored_poses.file_of(scene) for scene in bare} <= files


def test_poses_survive_the_disk_and_a_changed_scene_finds_none(tmp_path):
    scene = scenes.make("android_simplified", **BARE)
    times, still = np.array([0.0, 0.1, 0.2]), np.zeros((3, 13, 2))
    arrays = (still, still[..., 0], still, still[..., 0], times)
    position, orientation, *rates = arrays
    truth = Truth(position, orientation, 1e-12, "converged", "made up", 2e-12, True, *rates)
    stored_poses.save(scene, times, truth, tmp_path)
    found = stored_poses.load(scene, times[[0, 2]], tmp_path)
    assert found is not None
    assert found.is_costly
    assert found.rate_uncertainty.tolist() == [0.0, 0.2]
    assert (found.uncertainty, found.difference, found.how) == (1e-12, 2e-12, "made up")
    assert stored_poses.load(scene, np.array([0.0, 0.15]), tmp_path) is None
    assert stored_poses.load(scenes.make("android_simplified", mass=80.0, **BARE), times, tmp_path) is None
