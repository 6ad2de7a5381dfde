"""Files with more rows than are judged: every row is checked, regular ones and those that stand out remain."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.trajectory_files import columns, formats
from cross_checks.trajectory_files.columns import read_columns
from cross_checks.trajectory_files.formats import FileError
from cross_checks.trajectory_files.judgement import as_truth
from cross_checks.trajectory_files.motion import in_common, read_motion
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.poses_file import write_poses

ROWS = 1000


@pytest.fixture(autouse=True)
def small_parts(monkeypatch):
    monkeypatch.setattr(formats, "PART", 300)
    monkeypatch.setattr(columns, "MOST_ROWS", 50)


def written(path, table):
    match path.suffix:
        case ".npz":
            np.savez_compressed(path, t=table[:, 0], x=np.asfortranarray(table[:, 1:]))
        case _:
            np.savetxt(path, table, delimiter=",", header="t,x[0],x[1]", comments="")
    return path


def spiked():
    t = np.arange(ROWS) / ROWS
    table = np.column_stack((t, np.sin(t), np.cos(t)))
    table[777, 2] += 1e-3
    return table


@pytest.mark.parametrize("name", ["tool.csv", "tool.npz"])
def test_a_long_file_is_thinned_evenly_and_rows_that_stand_out_remain(name, tmp_path):
    table, seen = spiked(), []
    read = read_columns(written(tmp_path / name, table), report=lambda done, total, what: seen.append(done / total))
    first = 2 if read.word == "line" else 0
    rows = read.counted - first
    assert (read.total, read.stride) == (ROWS, 32)
    assert set(range(0, ROWS, 32)) | {777, ROWS - 1} <= set(rows)
    assert len(rows) < 50 + 2 * len(seen)
    for k, column in enumerate(("t", "x[0]", "x[1]")):
        assert np.array_equal(read.values[column], table[rows, k])
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


@pytest.mark.parametrize("name", ["tool.csv", "tool.npz"])
def test_a_mistake_in_any_row_is_named_with_its_place(name, tmp_path):
    number = 779 if name.endswith("csv") else 777
    for value, message in ((np.nan, f"{number}, column 'x[1]': nan is not finite"), (0.1, "times must increase")):
        table = spiked()
        table[777, 2 if np.isnan(value) else 0] = value
        with pytest.raises(FileError, match=message.replace("[", r"\[").replace("]", r"\]")):
            read_columns(written(tmp_path / name, table))


def test_two_long_files_are_compared_at_the_times_of_the_shorter(tmp_path):
    scene, files = scenes.make("pendulum"), []
    for samples in (401, 1201):
        path = simulate(scene, Settings(rtol=1e-10, samples=samples, estimate="off", reactions=False))
        files.append((tmp_path / f"{samples}.npz", None))
        write_poses(path, list(scene.body_names), files[-1][0])
    for both in (files, files[::-1]):
        ours, truth = as_truth(scene, *in_common(scene, both, lambda done, total, what: None), "other")
        assert 50 >= len(ours.path.times) > 20
        assert np.max(np.abs(ours.path.position - truth.position)) < 1e-7


@pytest.mark.parametrize("name", ["tool.csv", "tool.npz"])
def test_what_the_header_decides_is_stated_before_the_rows_are_read(name, tmp_path):
    table = spiked()
    table[-1, 1] = np.nan
    file = written(tmp_path / name, table)
    with pytest.raises(FileError, match="its columns are not those that mbs-ref writes of pendulum"):
        read_motion(file, scenes.make("pendulum"))
    (tmp_path / "map.toml").write_text('[time]\ncolumn = "t"\nunit = "s"\n[bodies.rob]\n')
    with pytest.raises(FileError, match="the scene has no such body; did you mean 'bob'"):
        read_motion(file, scenes.make("pendulum"), tmp_path / "map.toml")
