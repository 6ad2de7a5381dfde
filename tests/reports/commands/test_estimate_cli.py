"""The error estimate on the command line: printed, in JSON, kept in files, and in the exit code."""

from __future__ import annotations

import json
from contextlib import nullcontext

import numpy as np
import pytest
from click.testing import CliRunner, Result

from reports.cli import main
from reports.commands.maintenance import calibrate
from reports.console import Failed, NothingSelected


def run(*words: str) -> Result:
    return CliRunner().invoke(main, list(words), prog_name="mbs-ref")


def test_a_run_prints_and_keeps_its_estimate(tmp_path):
    target = tmp_path / "poses.npz"
    done = run("simulate", "pendulum", "--t-end", "1", "-o", str(target))
    assert done.exit_code == 0, done.output
    assert "estimated error" in done.output
    estimate = np.load(target)["estimate"]
    assert estimate.shape == np.load(target)["times"].shape
    assert estimate[0] == 0.0 < estimate[-1]


def test_json_holds_the_estimate_beside_the_error():
    done = run("simulate", "pendulum", "--t-end", "4", "--samples", "5", "--rtol", "1e-5", "--json")
    record = json.loads(done.stdout)
    estimate, error = record["estimate"], record["error"]
    assert estimate["unit"] == "of the scene"
    assert (estimate["length"], estimate["time"]) == (error["length"], error["time"])
    assert error["value"] <= estimate["value"] <= 10.0 * error["value"]
    assert "difference from a run with 1/10 of the tolerance" in estimate["how"]
    assert estimate["holds_until"] is None
    assert estimate["cost_s"] > 0.0
    assert record["history"]["estimate"][-1] == estimate["value"]
    assert json.loads(run("simulate", "pendulum", "--estimate", "off", "--json").stdout)["estimate"] is None


def test_a_run_that_is_lost_on_the_way_says_so_and_one_without_a_digit_fails():
    lost = run(
        "simulate", "double_pendulum", "-p", "angle_1=2.0", "-p", "angle_2=2.5", "--t-end", "20", "--no-truth", "--json"
    )
    assert lost.exit_code == 0, lost.output
    assert 5.0 < json.loads(lost.stdout)["estimate"]["holds_until"] < 20.0
    assert any("the digits hold until" in note for note in json.loads(lost.stdout)["notes"])
    void = run("simulate", "pendulum", "--method", "rk4", "--step", "0.5", "--t-end", "10", "--samples", "2")
    assert void.exit_code == 1
    assert "no output has a digit" in void.output


def test_a_few_random_runs_are_calibrated(tmp_path):
    target = tmp_path / "table.json"
    done = run("calibrate", "-n", "3", "--json", "--table", str(target))
    found = json.loads(done.stdout)
    assert found["table"][0]["method"] == "all"
    assert json.loads(target.read_text())["table"] == found["table"]
    assert len(found["runs"]) == found["table"][0]["runs"] == 3
    assert run("calibrate", "-n", "2", "--shard", "3/3").exit_code == 5


@pytest.mark.parametrize(("judged", "share", "median", "said"), [
    (300, 0.01, 10.0, ""), (300, 0.0101, 10.0, "3 of 300 runs have an error above their estimate"),
    (300, 0.01, 12.345, "the median estimate is 12.3 times the error"), (300, 0.0, None, ""),
    (0, None, None, "no run could be judged"), (300, 0.5, 99.0, "3 of 300 runs have an error above their estimate"),
])  # fmt: skip
def test_estimates_are_honest_up_to_a_hundredth_below_and_ten_times_above(judged, share, median, said):
    row = {"judged": judged, "below": 3, "share_below": share, "overestimate_median": median}
    with nullcontext() if not said else pytest.raises((Failed, NothingSelected)) as raised:
        calibrate._judge(row)
    assert not said or (raised.value.message, raised.value.exit_code) == (said, 1 if judged else 5)  # type: ignore[union-attr]
