"""`cross_checks.judge` takes trajectories, files, data frames and arrays, and returns one verdict for all."""

from __future__ import annotations

import numpy as np
import pytest

import cross_checks
import mbs_ref
from cross_checks.trajectory_files.formats import FileError
from reports.poses_file import write_poses

pytest_plugins = ["pytester"]
SCENE = mbs_ref.scenes.make("pendulum")
PATH = mbs_ref.simulate(SCENE, mbs_ref.Settings(t_end=0.5, samples=6))
ERROR = 1e-3  # of the scene: above the run's error, below the mistake's
MAP = """
[time]
column = "t"
unit = "s"
[bodies.{body}]
position = {{ columns = ["r[0]", "r[1]"], unit = "mm" }}
"""


@pytest.fixture(autouse=True)
def store(tmp_path, monkeypatch):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "store.sqlite"))


@pytest.fixture
def file(tmp_path):
    write_poses(PATH, SCENE.body_names, tmp_path / "motion.csv")
    return tmp_path / "motion.csv"


def test_a_trajectory_its_file_and_its_data_frame_have_one_verdict(file):
    pandas = pytest.importorskip("pandas")
    motions = (PATH, file, str(file), pandas.read_csv(file))
    judged = [cross_checks.judge(SCENE, motion, error=ERROR) for motion in motions]
    assert {one.verdict for one in judged} == {"agrees"}
    assert [one.error.value for one in judged] == pytest.approx([judged[0].error.value] * len(motions), rel=1e-6)


def test_arrays_are_judged_by_a_map_and_a_wrong_unit_is_suspected(tmp_path):
    column_map = tmp_path / "map.toml"
    column_map.write_text(MAP.format(body=SCENE.body_names[0]))
    metres = {"t": PATH.times, "r": PATH.position[:, 0]}
    millimetres = metres | {"r": 1e3 * metres["r"]}
    assert cross_checks.judge(SCENE, millimetres, error=ERROR, column_map=column_map).verdict == "agrees"
    wrong = cross_checks.judge(SCENE, metres, error=ERROR, column_map=column_map)
    assert wrong.verdict == "departs"
    assert wrong.suspicions
    assert not [note for note in wrong.notes if "energy" in note]  # without velocities nothing is known of it
    assert wrong.measures["energy_drift"] is None


def test_columns_without_a_map_are_refused():
    with pytest.raises(FileError, match="its columns are not those that mbs-ref writes"):
        cross_checks.judge(SCENE, {"t": PATH.times, "r": PATH.position[:, 0]})


@pytest.mark.parametrize("name", ["pendulum", "torque_free_top"])
def test_poses_and_rates_are_judged_with_their_times(name):
    scene = mbs_ref.scenes.make(name)
    path = mbs_ref.simulate(scene, mbs_ref.Settings(t_end=0.5, samples=6, rtol=1e-10))
    turns = path.orientation[..., None] if scene.dimension == 2 else path.orientation
    spins = path.angular_velocity[..., None] if scene.dimension == 2 else path.angular_velocity
    poses, rates = np.concatenate([path.position, turns], 2), np.concatenate([path.velocity, spins], 2)
    full = cross_checks.judge(scene, path.times, poses, rates)
    alone = cross_checks.judge(scene, path.times.tolist(), path.position[:, 0].tolist())
    assert (full.verdict, full.missing, alone.verdict) == ("agrees", (), "agrees")
    assert "orientation" in alone.missing[0] or name == "pendulum"
    assert cross_checks.judge(scene, path.times, path.position + 0.01, error=1e-4).verdict == "departs"


@pytest.mark.parametrize("poses", [np.zeros((6, 1, 5)), np.zeros((5, 1, 3)), np.zeros(6)])
def test_poses_of_another_shape_are_refused_with_the_shapes_allowed(poses):
    with pytest.raises(FileError, match=r"poses has the shape .*; expected: \(6, 1, 2\) or \(6, 1, 3\)"):
        cross_checks.judge(SCENE, PATH.times, poses)


TESTS = """
import numpy as np
import mbs_ref

SCENE = mbs_ref.scenes.make("pendulum")

def swing(gravity):
    changed = SCENE.model_copy(update={"gravity": (0.0, gravity)})
    run = mbs_ref.simulate(changed, mbs_ref.Settings(t_end=0.5, samples=6, rtol=1e-9, estimate="off"))
    return run.times, run.position

def test_right(mbs_judge):
    assert mbs_judge(SCENE, *swing(SCENE.gravity[1]), error=1e-6).error.value < 1e-6

def test_of_arrays_by_name(mbs_judge):
    times, place = swing(SCENE.gravity[1])
    mbs_judge(SCENE, {"t": times, "bob.x": place[:, 0, 0], "bob.y": place[:, 0, 1]}, error=1e-6)

def test_wrong(mbs_judge):
    mbs_judge(SCENE, *swing(1.1 * SCENE.gravity[1]), error=1e-6)
"""


def test_the_fixture_fails_a_test_of_a_wrong_motion_and_says_why(pytester):
    pytester.makepyfile(TESTS)
    result = pytester.runpytest("-p", "no:cacheprovider")
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(["pendulum departs: off by * of the scene in * of bob at t = *; the limit is 1e-06"])
