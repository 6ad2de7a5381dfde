"""Commands of the trade through the entry point: choosing, comparing, resuming, certifying, and the night."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from benchmarks.history import Entry
from benchmarks.trees import regression, slowed
from benchmarks.trees.regression import Case, Finding
from cross_checks.isolation.parent import Lost
from cross_checks.prices import pick
from cross_checks.prices.timing import Comparison, Pace
from cross_checks.records import lines as record_file
from cross_checks.records.record import Error, Record
from mbs_ref import scenes
from reports.cli import main
from reports.commands.maintenance import nightly

PENDULUM = scenes.make("pendulum")
RECORD = Record(
    scene="pendulum", parameters=dict(PENDULUM.parameters), engine="mbs_ref", method="rk4",
    settings={"method": "rk4", "step": 0.01}, status="success", message="", t_end=10.0, steps=1000, rhs_calls=4000,
    final={}, measures={"compliance_position": 1e-12, "compliance_velocity": 1e-12, "energy_drift": None},
    error=Error(1e-7, "exact: made up", 1e-14, 1e-7), times={"loop_s": 1e-3}, versions={},
)  # fmt: skip
DEAR = replace(RECORD, method="euler", settings={"method": "euler", "step": 0.01}, times={"loop_s": 1.0})


def run(*words: str):
    return CliRunner().invoke(main, list(words), prog_name="mbs-ref")


def file_of(tmp_path, name: str, *records: Record) -> str:
    record_file.append(tmp_path / name, records)
    return str(tmp_path / name)


def test_pick_chooses_among_records(tmp_path):
    file = file_of(tmp_path, "r.jsonl", RECORD, DEAR, replace(RECORD, scene="other"))
    done = run("pick", "pendulum", "--error", "1e-6", "--records", file, "--json")
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert (found["best"]["method"], found["runner_up"]["method"], found["margin"]) == ("rk4", "euler", 1000.0)
    assert found["duel"] is None  # a margin of 1000 needs no confirmation
    assert run("pick", "heavy_top", "--error", "1e-6", "--records", file).exit_code == 5


def test_a_duel_that_is_lost_leaves_the_choice_unconfirmed(tmp_path, monkeypatch):
    def duel(scene, choice, call):
        raise Lost("timeout", "gave no answer within 120 s and was stopped")

    monkeypatch.setattr(pick, "duel", duel)
    file = file_of(tmp_path, "r.jsonl", RECORD, DEAR)
    done = run("pick", "pendulum", "--error", "1e-6", "--records", file, "--confirm")
    assert done.exit_code == 0
    assert "Not confirmed: a timed run gave no answer within 120 s" in done.stdout


@pytest.mark.parametrize(
    ("again", "code"),
    [(RECORD, 0), (replace(RECORD, status="diverged", error=None), 1), (replace(RECORD, status="timeout"), 4)],
)
def test_a_setting_run_afresh_meets_misses_or_was_not_measured(tmp_path, monkeypatch, again, code):
    monkeypatch.setattr(pick, "afresh", lambda scene, record, truth, call: again)
    file = file_of(tmp_path, "r.jsonl", RECORD)
    assert run("pick", "pendulum", "--error", "1e-6", "--records", file, "--fresh").exit_code == code


def test_pick_says_what_a_named_engine_does_as_it_comes(tmp_path, monkeypatch):
    monkeypatch.setattr(pick, "as_shipped", lambda runs, scene, engine: replace(RECORD, engine=engine))
    file = file_of(tmp_path, "r.jsonl", RECORD)
    asked = ("pick", "pendulum", "--error", "1e-6", "--records", file)
    assert "as it comes" not in run(*asked).stdout
    done = run(*asked, "--engine", RECORD.engine, "--real-time")
    assert f"{RECORD.engine} as it comes" in done.stdout
    assert run(*asked, "--engine", RECORD.engine, "--json").exit_code == 0


def test_pick_refuses_what_the_truth_cannot_judge(tmp_path):
    assert RECORD.error is not None
    unsure = replace(RECORD, error=replace(RECORD.error, uncertainty=1e-9))
    done = run("pick", "pendulum", "--error", "9e-10", "--records", file_of(tmp_path, "r.jsonl", unsure))
    assert done.exit_code == 5
    assert "resolves no error below 1.0e-09 of it" in done.stderr


def test_compare_files(tmp_path):
    a = file_of(tmp_path, "a.jsonl", RECORD, DEAR)
    assert RECORD.error is not None
    worse = replace(RECORD, error=replace(RECORD.error, value=1e-3))
    b = file_of(tmp_path, "b.jsonl", worse, DEAR)
    assert run("compare", a, a).exit_code == 0
    done = run("compare", a, b)
    assert done.exit_code == 1
    assert "error 1.00e-07, then 1.00e-03" in done.stdout
    found = json.loads(run("compare", a, b, "--json").stdout)
    assert (found["verdict"], len(found["runs"]), found["median_time_ratio"]) == ("worse", 2, 1.0)
    assert run("compare", a, ".").exit_code == 2
    assert run("compare", a, str(tmp_path / "absent.jsonl")).exit_code == 2
    assert run("compare", a, file_of(tmp_path, "c.jsonl", replace(RECORD, engine="x"))).exit_code == 5


@pytest.mark.slow
def test_parts_of_a_check_are_disjoint_and_complete(tmp_path):
    words = ["check", "pendulum", "--engine", "mbs_ref", "--json", "--store", str(tmp_path / "s.sqlite"), "--shard"]
    whole, *parts = [json.loads(run(*words, part).stdout) for part in ("1/1", "1/2", "2/2")]
    assert sorted(cell["method"] for part in parts for cell in part) == sorted(cell["method"] for cell in whole)
    assert run(*words, "3/2").exit_code == 2
    assert run(*words, "99/99").exit_code == 5


def test_certify():
    done = run("certify", "pendulum", "--json")
    assert done.exit_code == 0, done.output
    (row,) = json.loads(done.stdout)
    assert row["verdict"] == "holds"
    assert run("certify", "rocking_block").exit_code == 5


@pytest.fixture
def night(monkeypatch, tmp_path):
    """A night on one case whose verdict the test says, and one sweep whose records it says."""
    said = {"pace": "same", "records": [RECORD, DEAR]}

    def regressions(baseline, current, cases, report):
        timing = Comparison(Pace.SAME, 1.01, 0.99, 1.02, 10, 0.0)
        for case in cases:
            yield Finding(case.name, said["pace"], "steady", 1e-6, None if said["pace"] == "not measured" else timing)

    def sweep_records(scene, chosen, methods, target):
        record_file.append(target, said["records"])
        return said["records"]

    monkeypatch.setattr(regression, "CASES", (Case("pendulum", "rk4"),))
    monkeypatch.setattr(regression, "regressions", regressions)
    monkeypatch.setattr(nightly, "SWEPT", (("pendulum", {}),))
    monkeypatch.setattr(nightly, "sweep_records", sweep_records)
    said["words"] = ["nightly", "--baseline", ".", "--file", str(tmp_path / "history.jsonl"),
                     "--sweeps", str(tmp_path / "sweeps"), "--trends", str(tmp_path / "trends.html")]  # fmt: skip
    return said


def test_a_night_is_kept_and_drawn(night, tmp_path):
    for _ in range(2):
        done = run(*night["words"])
        assert done.exit_code == 0, done.output
        assert done.stdout.splitlines()[0] == "pendulum mbs_ref rk4: same: steady"
    found = json.loads(run("history", "--file", str(tmp_path / "history.jsonl"), "--json").stdout)
    assert found["ratio pendulum mbs_ref rk4"]["values"] == [1.01, 1.01]
    assert found["loop pendulum mbs_ref within 1e-06 of the scene"]["values"] == [1e-3, 1e-3]
    entries, problems = record_file.read(tmp_path / "history.jsonl", Entry)
    kept = [(e.series.split()[0], e.value, e.unit, e.verdict, e.error) for e in entries]
    cheapest = ("loop", 1e-3, "s", "mbs_ref rk4 step=0.01", pytest.approx(1e-7, rel=1e-6))
    assert (kept, problems) == ([("ratio", 1.01, "1", "same", 1e-6), cheapest] * 2, [])
    assert [len({getattr(e, name) for e in entries}) for name in ("job", "commit_id", "machine")] == [2, 1, 1]
    assert "plotly" in (tmp_path / "trends.html").read_text()
    assert (tmp_path / "sweeps-before" / "pendulum.jsonl").is_file()


@pytest.mark.parametrize(("pace", "code"), [("slower", 1), ("not measured", 4), ("inconclusive", 4), ("faster", 0)])
def test_slower_and_not_measured_differ(night, pace, code):
    night["pace"] = pace
    assert run(*night["words"]).exit_code == code


def test_a_night_without_any_case_ends_before_any_work(night, tmp_path):
    done = run(*night["words"], "--only", "pendulum links=3")
    assert done.exit_code == 5
    assert "pendulum mbs_ref rk4" in done.output
    assert not list(tmp_path.iterdir())


def test_a_sweep_that_became_less_accurate_fails_the_night(night):
    assert run(*night["words"]).exit_code == 0
    night["records"] = [replace(RECORD, status="diverged"), DEAR]
    done = run(*night["words"])
    assert done.exit_code == 1
    (worse,) = [line for line in done.stdout.splitlines() if "worse than last night" in line]
    assert worse == "pendulum mbs_ref rk4 step=0.01: worse than last night: success, then diverged"


@pytest.mark.parametrize(("percent", "sentence"), [("15", "B takes 15.0% longer"), ("0", "B takes 0.0% longer")])
def test_a_version_is_compared_with_a_copy_that_is_slower_by_a_known_share(night, monkeypatch, percent, sentence):
    monkeypatch.setattr(slowed, "copy_tree", lambda folder: folder)
    monkeypatch.setattr(slowed, "calibrate", lambda folder, case, share: (7, share))
    done = run("compare", ".", "--slowed", percent, "--only", "rk4")
    assert done.exit_code == 0, done.output
    assert sentence in done.stderr
