"""The command line through its entry point: what it prints where, and its exit codes.

The judge and the sweeps are stood in for by quick fakes here; what they find is tested with them.
"""

from __future__ import annotations

import json
import math
import shlex
import subprocess
import sys
from dataclasses import replace
from importlib.metadata import entry_points
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner

from cross_checks import engines
from cross_checks.engine import Engine, Method
from cross_checks.judge import one_run as compare
from cross_checks.judge import runs as judged_runs
from cross_checks.judge.answers import Answer
from cross_checks.judge.vocabulary import Cell, Verdict
from cross_checks.prices import pick as picking
from cross_checks.prices import sweep as sweeps
from cross_checks.prices.pick import Choice
from cross_checks.records.record import Error, Record
from cross_checks.truths import seek_truth
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.scene.contact import HuntCrossleyLaw
from mbs_ref.scene.toml import write_scene
from mbs_ref.trajectory import Trajectory
from reports.cli import main
from reports.commands.judge import check as checking

RECORD = Record(
    scene="pendulum", parameters={}, engine="quick", method="rk4", settings={"step": 0.01}, status="success",
    message="", t_end=1.0, steps=100, rhs_calls=400,
    final={"bob": {"position": [0.0, -1.0], "angle": None, "velocity": [1.0, 0.0], "angular_velocity": None}},
    measures={"compliance_position": 1e-12, "compliance_velocity": math.nan, "energy_drift": 1e-9},
    error=Error(1e-9, "exact", 1e-14, 1e-9),
    times={"build_s": 0.1, "first_call_s": 0.1, "loop_s": 0.01}, versions={"quick": "1"},
)  # fmt: skip


class Quick(Engine):
    """An engine that stands still."""

    name = "quick"
    package = "numpy"
    part_types = frozenset({"point_mass", "distance", "planar", "revolute"})

    def methods(self) -> tuple[Method, ...]:
        return (
            Method("rk4", "fixed", 4, "stands still"),
            Method("soft", "fixed", None, "stands wrong", wrong_limit="loops are springs"),
        )

    def version(self) -> str:
        return "1"

    def run(self, scene, settings, times=None) -> Trajectory:
        shape = (settings.samples, len(scene.bodies))
        still, flat = np.zeros((*shape, 2)), np.zeros(shape)
        return Trajectory(np.linspace(0.0, 1.0, settings.samples), still, flat, still, flat)


def cell(method: str = "rk4", verdict: str = "agrees") -> Cell:
    exemption = "loops are springs" if method == "soft" else ""
    return Cell("pendulum", {}, "quick", method, Verdict(verdict), "the reason", exemption, 1e-9, 1e-12, math.nan)


def get(name: str) -> Engine:
    if name == "quick":
        return Quick()
    if name == "gone":
        raise engines.EngineMissing("engine 'gone' needs the package 'gone'")
    raise ValueError(f"engine = {name!r} is unknown; allowed: quick, gone")


@pytest.fixture
def stand(monkeypatch, tmp_path):
    """Put fakes where the judge, the sweeps and the engines are; a test changes what they answer."""
    choice = Choice(RECORD, None, None, "quick rk4 reaches it")
    fakes: dict[str, Any] = {"record": RECORD, "cells": [cell()], "records": [RECORD], "choice": choice, "asked": {}}

    def evaluate(scene, engine, settings, times=None):
        fakes["asked"] = {"scene": scene, "engine": engine, "settings": settings}
        return fakes["record"]

    def judged_run(scene, engine, settings, *, truth):
        return evaluate(scene, engine, settings), Quick().run(scene, settings)

    def answers(runs, asked, progress):
        progress(1, 1, "done")
        fakes["asked"] = {
            "scenes": list(dict.fromkeys(question.scene.name for question in asked)),
            "engines": list(dict.fromkeys(question.engine for question in asked)),
        }
        for question, one in zip(asked, fakes["cells"], strict=False):
            if isinstance(one, BaseException):
                raise one
            yield Answer(question, one, (), NoTruth("told"), True)

    def sweep(runs, scene, engine_names, methods, progress, targets, seen, worth):
        fakes["asked"] = {"scene": scene, "engines": engine_names, "methods": methods}
        if methods == ["rk5"]:
            raise ValueError("method = rk5 is offered by none of the engines asked")
        seen([one for one in fakes["records"] if isinstance(one, Record)])
        for record in fakes["records"]:
            if isinstance(record, BaseException):
                raise record
            yield record

    def pick(records, error, compliance, budget):
        fakes["asked"] = {"error": error, "compliance": compliance, "budget": budget, "records": records}
        return fakes["choice"]

    monkeypatch.setattr(compare, "evaluate", evaluate)
    monkeypatch.setattr(compare, "judged_run", judged_run)
    monkeypatch.setattr(checking, "answers", answers)
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "runs.sqlite"))
    monkeypatch.setattr(sweeps, "sweep", sweep)
    monkeypatch.setattr(picking, "pick", pick)
    monkeypatch.setattr(engines, "get", get)
    monkeypatch.setattr(engines, "names", lambda: ["quick", "gone"])
    return fakes


def run(*words: str):
    return CliRunner().invoke(main, list(words), prog_name="mbs-ref")


def test_the_entry_point_is_installed():
    (script,) = entry_points(group="console_scripts", name="mbs-ref")
    assert script.load() is main


def test_the_program_starts_and_explains_itself():
    done = subprocess.run(
        [sys.executable, "-c", "from reports.cli import main; main()", "--help"],
        capture_output=True,
        text=True,
        check=True,
    )
    for command in ("check", "doctor", "engines", "ensemble", "pick", "report", "scenes", "simulate", "sweep"):
        assert f"\n  {command} " in done.stdout
    assert "Exit codes" in done.stdout
    assert not done.stderr


@pytest.mark.parametrize("command", ["check", "doctor", "engines", "pick", "report", "scenes", "simulate", "sweep"])
def test_every_command_has_help(command):
    done = run(command, "--help")
    assert done.exit_code == 0
    assert "Usage: mbs-ref" in done.output


def test_an_unknown_command_suggests_the_closest():
    done = run("simulat")
    assert done.exit_code == 2
    assert "did you mean 'simulate'?" in done.stderr
    assert not done.stdout


def test_scenes():
    listed = json.loads(run("scenes", "--json").stdout)
    assert [item["name"] for item in listed] == scenes.names()
    assert all(item["summary"] for item in listed)
    assert "pendulum" in run("scenes").stdout


def test_inspect_tells_the_modes_of_a_steady_motion_or_why_there_are_none():
    """Capsize and castering of the bicycle at 5 m/s, Meijaard et al. 2007, Table 2."""
    steady = json.loads(run("inspect", "bicycle", "-p", "speed=5", "-p", "roll_rate=0", "--json").stdout)
    real = [value for value, imaginary in steady["steady_motion_1_s"] if imaginary == 0.0]
    assert min(abs(value + 0.32286642900409) for value in real) < 1e-11
    assert min(abs(value + 14.07838969279822) for value in real) < 1e-11
    assert "accelerated" in json.loads(run("inspect", "bicycle", "--json").stdout)["steady_motion_1_s"]
    shown = run("inspect", "spring_pendulum").stdout  # its spring swings at sqrt(k/m) = 10 per second
    assert "± 10i" in shown
    assert "rule_" not in shown  # of contacts, and there are none


def test_engines_says_who_is_missing(stand):
    found = {item["engine"]: item for item in json.loads(run("engines", "--json").stdout)}
    assert not found["gone"]["installed"]
    assert found["quick"]["parts"]["revolute"]
    assert not found["quick"]["parts"]["weld"]
    assert found["quick"]["scenes"]["pendulum"] == []
    assert "spring_damper" in found["quick"]["scenes"]["spring_pendulum"][0]
    shown = run("engines").stdout
    assert "missing" in shown
    assert "not yet" in shown


def test_simulate_prints_the_record(stand):
    done = run(
        "simulate", "pendulum", "-p", "length=2", "--engine", "quick", "--step", "0.01", "--samples", "5", "--json"
    )
    assert done.exit_code == 0
    record = json.loads(done.stdout)
    needed = {"scene", "engine", "method", "settings", "status", "message", "t_end", "steps", "rhs_calls", "final",
              "measures", "error", "times", "versions"}  # fmt: skip
    assert needed <= record.keys()
    assert record["measures"]["compliance_velocity"] is None  # a NaN is no JSON
    assert stand["asked"]["scene"].parameters["length"] == 2
    settings = stand["asked"]["settings"]
    assert (settings.method, settings.step, settings.samples) == ("rk4", 0.01, 5)


def test_simulate_speaks_to_a_person(stand):
    done = run("simulate", "pendulum", "--engine", "quick")
    assert done.exit_code == 0
    assert done.stdout.index("At the end") < done.stdout.index("of the scene (")
    assert "nan" not in done.stdout


def test_simulate_makes_a_truth_once_or_not_at_all(stand, monkeypatch):
    made = []
    monkeypatch.setattr(judged_runs, "seek_truth", lambda *asked: made.append(asked) or seek_truth(*asked))
    words = ("simulate", "pendulum", "--engine", "quick")
    assert "Against the truth" not in run(*words, "--no-truth").stdout
    assert made == []
    assert run(*words).stdout == run(*words).stdout
    assert len(made) == 1


def test_an_engine_s_file_stands_for_its_name(stand, monkeypatch, tmp_path):
    monkeypatch.setenv(engines.ADAPTERS, "")
    file = tmp_path / "quick_.py"
    file.write_text("found by its name, which the fake knows")
    for words in (["check", "pendulum"], ["sweep", "pendulum"], ["pick", "pendulum", "--error", "1e-3"]):
        assert run(*words, "--engine", str(file)).exit_code == 0
        if words[0] != "pick":
            assert stand["asked"]["engines"] == ["quick"]
    assert f"--engine {file}" in run("pick", "pendulum", "--error", "1e-3", "--engine", str(file)).stdout
    done = run("check", "pendulum", "--engine", str(tmp_path / "none_.py"))
    assert (done.exit_code, "there is no such file" in done.stderr) == (2, True)


def test_pick_says_how_to_run_a_scene_s_file(stand, tmp_path):
    write_scene(scenes.make("slider_crank"), tmp_path / "mine.toml")
    done = run("pick", str(tmp_path / "mine.toml"), "--error", "1e-3")
    assert f"mbs-ref simulate {tmp_path / 'mine.toml'} --engine quick --method rk4 --step 0.01" in done.stdout


def test_simulate_takes_a_file(stand, tmp_path):
    write_scene(scenes.make("n_four_bar"), tmp_path / "mine.toml")
    assert run("simulate", str(tmp_path / "mine.toml"), "--engine", "quick").exit_code == 0
    assert stand["asked"]["scene"] == scenes.make("n_four_bar")


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_simulate_writes_poses(stand, tmp_path, suffix):
    file = tmp_path / f"poses{suffix}"
    words = ("simulate", "pendulum", "--engine", "quick", "--samples", "4", "--no-truth")
    assert run(*words, "-o", str(file)).exit_code == 0
    if suffix == ".npz":
        assert np.load(file)["position"].shape == (4, 1, 2)
    else:
        header, *rows = file.read_text().splitlines()
        assert header.startswith("t,")
        assert header.split(",")[1].endswith(".x")
        assert len(rows) == 4
    assert [entry.name for entry in tmp_path.iterdir()] == [file.name]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["pendulam"], "did you mean 'pendulum'?"),
        (["pendulum", "-p", "lenght=2"], "did you mean 'length'?"),
        (["pendulum", "-p", "length"], "must be name=value"),
        (["pendulum", "-p", "length=1", "-p", "length=2"], "given twice"),
        (["pendulum", "-p", "length=nan"], "finite number"),
        (["pendulum", "-p", "mass=0"], "mass = 0"),
        (["pendulum", "-p", "mass=heavy"], "mass = 'heavy'"),
        (["pendulum", "--engine", "quik"], "engine = 'quik' is unknown"),
        (["pendulum", "--engine", "quick", "--method", "rk5"], "did you mean 'rk4'?"),
        (["pendulum", "--step", "nan"], "step = nan: must be a finite number"),
        (["pendulum", "--step", "-1"], "step = -1.0: must be greater than 0"),
        (["pendulum", "--t-end", "0"], "t_end = 0.0: must be greater than 0"),
        (["pendulum", "--samples", "1"], "samples = 1: must be greater than or equal to 2"),
        (["pendulum", "--rtol", "1e-9", "--step", "0.1"], "either step or rtol/atol"),
        (["pendulum", "--stabilization", "hope"], "'hope': must be 'none', 'baumgarte' or 'projection'"),
        (["pendulum", "--stp", "1"], "--stp"),
        (["pendulum", "-o", "poses.txt"], "suffix '.txt' is unknown; allowed: .npz, .csv"),
        (["pendulum", "-o", "no/such/folder/poses.csv"], "there is no folder"),
        (["absent.toml"], "No such file"),
        (["absent.toml", "-p", "a=1"], "cannot be read"),
    ],
)
def test_a_mistake_is_one_sentence_and_exit_code_2(stand, words, complaint):
    done = run("simulate", *words, "--json")
    assert done.exit_code == 2, done.output
    assert complaint in done.stderr
    assert not done.stdout
    assert "pydantic" not in done.stderr
    assert "Traceback" not in done.stderr


def test_a_bad_scene_file_names_every_place(stand, tmp_path):
    file = tmp_path / "bad.toml"
    file.write_text('name = "x"\n[[bodies]]\ntype = "planar"\nname = "rod"\nmass = 0\ninertia = nan\n')
    done = run("simulate", str(file))
    assert done.exit_code == 2
    assert "bodies[0].mass (rod) = 0: must be greater than 0" in done.stderr
    assert "bodies[0].inertia (rod) = nan: must be a finite number" in done.stderr


def test_a_missing_engine_is_3(stand):
    for words in (["simulate", "pendulum"], ["check", "pendulum"], ["sweep", "pendulum"]):
        done = run(*words, "--engine", "gone")
        assert done.exit_code == 3
        assert "needs the package" in done.stderr


def test_a_run_that_fails_is_1_and_still_prints_its_record(stand, tmp_path):
    stand["record"] = replace(RECORD, status="inconsistent", message="joint 'pin' is open by 0.1 m", error=None)
    done = run("simulate", "pendulum", "--engine", "quick", "--json", "-o", str(tmp_path / "x.csv"))
    assert done.exit_code == 1
    assert json.loads(done.stdout)["status"] == "inconsistent"
    assert "joint 'pin' is open" in done.stderr
    assert not list(tmp_path.iterdir())


def test_check_prints_cells(stand):
    done = run("check", "pendulum", "--engine", "quick", "--json")
    assert done.exit_code == 0
    (shown,) = json.loads(done.stdout)
    assert (shown["verdict"], shown["code"]) == ("agrees", "MBS.V01")
    assert shown["order"] is None
    assert stand["asked"] == {"scenes": ["pendulum"], "engines": ["quick"]}
    assert "agrees" in run("check").stdout
    assert stand["asked"] == {"scenes": scenes.names(), "engines": ["quick", "gone"]}


@pytest.mark.parametrize(
    ("method", "verdict", "code"),
    [("rk4", "wrong-limit", 1), ("rk4", "failed", 1), ("soft", "wrong-limit", 0), ("rk4", "converging", 0),
     ("rk4", "cannot", 5)],
)  # fmt: skip
def test_check_s_exit_code_stands_for_the_table(stand, method, verdict, code):
    stand["cells"] = [cell(method, verdict)]
    assert run("check").exit_code == code


def test_check_lists_refusals_by_engine_and_reason(stand):
    stand["cells"] = [cell(), *(cell(method, "cannot") for method in ("rk4", "euler"))]
    rows = [line.split() for line in run("check").stdout.partition("Refused")[2].splitlines() if "quick" in line]
    assert rows == [["quick", "rk4,", "euler", "pendulum", "the", "reason"]]


def test_sweep_draws_what_it_measured(stand, tmp_path):
    assert run("sweep", "pendulum", "--plot", str(tmp_path / "plot.html")).exit_code == 0
    assert "quick" in (tmp_path / "plot.html").read_text(encoding="utf-8")


def test_sweep_writes_lines(stand, tmp_path):
    stand["records"] = [RECORD, replace(RECORD, engine="other", error=None)]
    file = tmp_path / "records.jsonl"
    done = run("sweep", "pendulum", "--engine", "quick", "--json", "-o", str(file))
    assert done.exit_code == 0
    assert [json.loads(line)["engine"] for line in done.stdout.splitlines()] == ["quick", "other"]
    assert [json.loads(x) for x in file.read_text().splitlines()] == [json.loads(x) for x in done.stdout.splitlines()]
    assert run("sweep", "pendulum").exit_code == 0
    assert run("sweep", "pendulum", "--engine", "quick", "--method", "rk5").exit_code == 2


def test_sweep_writes_a_table_that_reads_back(stand, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    stand["records"] = [RECORD, replace(RECORD, engine="other", error=None)]
    file = tmp_path / "records.parquet"
    assert run("sweep", "pendulum", "-o", str(file)).exit_code == 0
    table = parquet.read_table(file).to_pylist()
    assert [row["engine"] for row in table] == [RECORD.engine, "other"]
    assert table[1]["error"] is None


def test_a_table_without_pyarrow_is_refused_before_anything_runs(stand, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)  # as where it is not installed
    stand["records"] = [KeyboardInterrupt()]
    done = run("sweep", "pendulum", "-o", str(tmp_path / "records.parquet"))
    assert done.exit_code == 2
    assert "pip install 'mbs-ref[parquet]'" in done.stderr


@pytest.mark.parametrize("words", [("check",), ("sweep",), ("pick", "--error", "1e-3")])
def test_a_scene_that_starts_torn_is_refused_before_any_engine_is_asked(stand, tmp_path, words):
    command, *options = words
    scene, file = scenes.make("slider_crank"), tmp_path / "torn.toml"
    crank, *others = scene.bodies
    faster = crank.model_copy(update={"angular_velocity": 9.0})
    write_scene(scene.model_copy(update={"bodies": (faster, *others)}), file)
    refused = run(command, str(file), *options)
    assert refused.exit_code == 2
    assert "breaks joint" in refused.output
    assert "--keep" in refused.output
    assert not stand["asked"]
    assert run(command, str(file), *options, "--keep", f"{crank.name}.angular_velocity").exit_code == 0
    assert stand["asked"]


def test_an_interrupted_sweep_keeps_what_it_has(stand, tmp_path):
    stand["records"] = [RECORD, KeyboardInterrupt()]
    file = tmp_path / "records.jsonl"
    done = run("sweep", "pendulum", "-o", str(file))
    assert done.exit_code == 4
    assert "interrupted after 1 runs, 1 of them timed" in done.stderr
    assert len(file.read_text().splitlines()) == 1


def test_an_interrupted_check_shows_the_cells_it_has(stand):
    stand["cells"] = [cell(), KeyboardInterrupt()]
    done = run("check", "pendulum", "--engine", "quick", "--json")
    assert done.exit_code == 4
    assert len(json.loads(done.stdout)) == 1
    assert "interrupted after 1 of 2 cells" in done.stderr


def test_an_interrupted_run_prints_and_writes_what_there_is(stand, tmp_path):
    stand["record"] = replace(RECORD, status="interrupted", message="at t = 0.4 s the run was interrupted")
    done = run("simulate", "pendulum", "--engine", "quick", "--json", "-o", str(tmp_path / "x.csv"))
    assert done.exit_code == 4
    assert json.loads(done.stdout)["status"] == "interrupted"
    assert "at t = 0.4 s" in done.stderr
    assert (tmp_path / "x.csv").exists()


def test_pick(stand):
    done = run("pick", "pendulum", "--error", "1e-6", "--compliance", "1e-9", "--budget", "50ms", "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["best"]["engine"] == "quick"
    assert found["runner_up"] is None
    assert found["command"].startswith("mbs-ref simulate pendulum --engine quick --method rk4 --step 0.01")
    assert stand["asked"] == {"error": 1e-6, "compliance": 1e-9, "budget": pytest.approx(0.05), "records": [RECORD]}
    assert "quick rk4 reaches it" in run("pick", "pendulum", "--error", "1e-6").stdout
    stand["choice"] = Choice(None, None, None, "none reached it; the nearest is far")
    done = run("pick", "pendulum", "--error", "1e-6")
    assert done.exit_code == 5
    assert "the nearest is far" in done.stderr


@pytest.mark.parametrize(
    "words", [[], ["--error", "nan"], ["--error", "-1"], ["--error", "1", "--budget", "5 parsec"],
              ["--error", "1", "--budget", "0ms"], ["--error", "1", "--budget", "1.2.3s"]]
)  # fmt: skip
def test_pick_refuses_what_is_no_number(stand, words):
    assert run("pick", "pendulum", *words).exit_code == 2


@pytest.mark.parametrize(("error", "code"), [(1e-9, 0), (1.0, 1), (math.nan, 1)])
def test_doctor_runs_a_pendulum(stand, error, code):
    stand["record"] = replace(RECORD, error=Error(error, "exact", 1e-14, error))
    monkey = run("doctor", "--json")
    assert monkey.exit_code == code
    assert json.loads(monkey.stdout)["engines"]["gone"].startswith("missing")
    assert "numpy" in run("doctor").stdout


OPEN_LOOP = """
name = "open"
[[bodies]]
type = "planar"
name = "rod"
mass = 1.0
inertia = 0.1
position = [0.5, 0.0]
[[joints]]
type = "revolute"
name = "near"
body_a = "ground"
body_b = "rod"
point = [0.0, 0.0]
[[joints]]
type = "revolute"
name = "far"
body_a = "ground"
body_b = "rod"
point = [1.0, 0.0]
point_b = [1.0, 0.1]
"""


def test_a_loop_that_does_not_close_is_1_and_names_the_joint(tmp_path):
    (tmp_path / "open.toml").write_text(OPEN_LOOP)
    done = run("simulate", str(tmp_path / "open.toml"), "--json")
    assert done.exit_code == 1
    assert json.loads(done.stdout)["status"] == "inconsistent"
    assert "'far'" in done.stderr


def test_inspect_limits_the_step_of_a_contact_that_is_open(tmp_path):
    """Hertz: k d^(n + 1) / (n + 1) = m v^2 / 2 at the deepest point, and a slope of n k d^(n - 1) there."""
    scene = scenes.make("bouncing_ball")
    (floor,) = scene.contacts
    law = HuntCrossleyLaw(stiffness=1e6, exponent=1.5)
    write_scene(scene.model_copy(update={"contacts": (floor.model_copy(update={"law": law}),)}), tmp_path / "ball.toml")
    found = json.loads(run("inspect", str(tmp_path / "ball.toml"), "--json").stdout)
    (closed,), mass, speed = found["closed_contacts"], scene.bodies[0].mass, found["impact_speed_m_s"]
    depth = (2.5 * 0.5 * mass * speed**2 / 1e6) ** 0.4
    assert closed["stiffness_N_m"] == pytest.approx(1.5e6 * depth**0.5)
    assert closed["largest_step_s"]["rk4"] == pytest.approx(2.83 * math.sqrt(mass / closed["stiffness_N_m"]), rel=0.05)
    shown = run("inspect", str(tmp_path / "ball.toml")).stdout
    assert "N/m (impact at" in shown
    assert "no limit" not in shown
    assert "stability limits no step" in run("inspect", "newtons_cradle").stdout


def test_the_help_groups_every_command_and_cuts_no_summary():
    shown = run("--help").stdout
    assert "..." not in shown.partition("Run scenes")[2]
    listed = [line.split()[0] for line in shown.splitlines() if line.startswith("  ") and line[2:3].isalpha()]
    assert set(main.list_commands(click.Context(main))) <= set(listed)
    assert [line for line in shown.splitlines() if line.endswith(".:")] == []
    assert shown.index("simulate") < shown.index("judge ") < shown.index("pick ") < shown.index("nightly")


@pytest.mark.parametrize("name", main.list_commands(click.Context(main)))
def test_the_help_of_a_command_shows_an_example_of_it(name):
    command = main.get_command(click.Context(main), name)
    example, *words = shlex.split((command.epilog or "").removeprefix("Example: mbs-ref "))
    assert example == name
    known = {opt for param in command.params for opt in (*param.opts, *param.secondary_opts)}
    assert {word for word in words if word.startswith("-")} <= known
    if not isinstance(command, click.Group):
        command.make_parser(click.Context(command)).parse_args(list(words))
