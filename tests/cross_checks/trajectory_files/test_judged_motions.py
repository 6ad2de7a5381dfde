"""`cross_checks.judge` takes trajectories, files, data frames and arrays, and returns one verdict for all."""

from __future__ import annotations

import pytest

import cross_checks
import mbs_ref
from cross_checks.trajectory_files.columns import FileError
from reports.poses_file import write_poses

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
    judged = [cross_checks.judge(motion, SCENE, error=ERROR) for motion in motions]
    assert {one.verdict for one in judged} == {"agrees"}
    assert [one.error.value for one in judged] == pytest.approx([judged[0].error.value] * len(motions), rel=1e-6)


def test_arrays_are_judged_by_a_map_and_a_wrong_unit_is_suspected(tmp_path):
    column_map = tmp_path / "map.toml"
    column_map.write_text(MAP.format(body=SCENE.body_names[0]))
    metres = {"t": PATH.times, "r": PATH.position[:, 0]}
    millimetres = metres | {"r": 1e3 * metres["r"]}
    assert cross_checks.judge(millimetres, SCENE, error=ERROR, column_map=column_map).verdict == "agrees"
    wrong = cross_checks.judge(metres, SCENE, error=ERROR, column_map=column_map)
    assert wrong.verdict == "departs"
    assert wrong.suspicions


def test_columns_without_a_map_are_refused():
    with pytest.raises(FileError, match="its columns are not those that mbs-ref writes"):
        cross_checks.judge({"t": PATH.times, "r": PATH.position[:, 0]}, SCENE)
