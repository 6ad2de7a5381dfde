"""mbs-ref judge: a tool's file, its map, the verdict and the exit code."""

from __future__ import annotations

import json
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner, Result

from mbs_ref import scenes
from mbs_ref.scene.toml import dumps, read_scene
from mbs_ref.settings import Settings
from mbs_ref.simulate import simulate
from reports.cli import main
from reports.commands.judge import judge
from reports.commands.judge import judge as command_file
from reports.poses_file import write_poses

SCENE = scenes.make("pendulum", length=0.5)
MAP = """
[time]
column = "time"
unit = "ms"
[bodies.bob.position]
columns = ["px", "py"]
unit = "mm"
"""


def run(*words: str) -> Result:
    return CliRunner().invoke(main, ["judge", *words, "-p", "length=0.5"], prog_name="mbs-ref")


@pytest.fixture
def own_file(tmp_path):
    path = simulate(SCENE, Settings(method="dop853", rtol=1e-12, samples=21, estimate="off"))
    write_poses(path, list(SCENE.body_names), tmp_path / "run.csv")
    return tmp_path / "run.csv"


def as_a_tool_writes(own_file, drift=0.0):
    """Rewrite times in ms and positions in mm, the latter growing by `drift` per s."""
    rows = [line.split(",") for line in own_file.read_text().splitlines()[1:]]
    lines = ["time,px,py"]
    for t, x, y, *_ in rows:
        grown = 1e3 * (1.0 + drift * float(t))
        lines.append(f"{1e3 * float(t)!r},{grown * float(x)!r},{grown * float(y)!r}")
    target = own_file.with_name("tool.csv")
    target.write_text("\n".join(lines))
    return target


def test_a_file_of_our_own_needs_no_map_and_agrees(own_file):
    done = run(str(own_file), "pendulum", "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["verdict"] == "agrees"
    assert told["error"]["value"] < 1e-9
    assert {part["component"] for part in told["parts"]} == {"position", "orientation", "velocity", "angular velocity"}
    assert told["measures"]["energy_drift"] < 1e-9
    assert len(told["curves"]["t"]) == 21


def test_a_tools_file_is_read_by_its_map_and_judged_with_a_plot(own_file, tmp_path):
    stated = tmp_path / "map.toml"
    stated.write_text(MAP)
    right, wrong = as_a_tool_writes(own_file), None
    done = run(str(right), "pendulum", "--map", str(stated), "--plot", str(tmp_path / "error.html"))
    assert done.exit_code == 0, done.output
    assert "does not state velocity" in done.output
    assert "plotly" in (tmp_path / "error.html").read_text()
    wrong = as_a_tool_writes(own_file, drift=1e-3)
    done = run(str(wrong), "pendulum", "--map", str(stated))
    assert done.exit_code == 1
    assert "departs" in done.output
    assert run(str(wrong), "pendulum", "--map", str(stated), "--error", "10mm").exit_code == 0


def test_two_files_are_held_against_each_other(own_file):
    done = run(str(own_file), "pendulum", "--against", str(own_file), "--json")
    assert json.loads(done.stdout)["error"]["value"] == 0.0


def test_a_map_is_begun_and_one_that_is_missing_or_exists_is_a_sentence(own_file, tmp_path):
    tool = as_a_tool_writes(own_file)
    done = run(str(tool), "pendulum")
    assert done.exit_code == 2
    assert "state what they mean by --map" in done.output
    begun = tmp_path / "begun.toml"
    assert run(str(tool), "pendulum", "--write-map", str(begun)).exit_code == 0
    assert "time, px, py" in begun.read_text()
    assert "exists already" in run(str(tool), "pendulum", "--write-map", str(begun)).output
    done = run(str(tool), "pendulum", "--map", str(begun))
    assert done.exit_code == 2
    assert "has no column 't?'" in done.output


def test_what_cannot_be_read_is_a_sentence(tmp_path):
    assert "there is no such file" in run(str(tmp_path / "none.csv"), "pendulum").output
    (tmp_path / "bad.csv").write_text("t,x\n0,a\n")
    done = run(str(tmp_path / "bad.csv"), "pendulum")
    assert done.exit_code == 2
    assert "line 2, column 'x': 'a' is no number" in done.output


@pytest.mark.slow  # test_consensus.py shows what is agreed on, by engines that a script plays
def test_a_scene_of_the_users_own_is_judged_by_what_engines_agree_on(tmp_path):
    text = dumps(
        scenes.make("driven_pendulum").model_copy(update={"name": "mine", "gravity": (0.1, -9.0), "duration": 0.4})
    )
    (tmp_path / "mine.toml").write_text(text)
    scene = read_scene(str(tmp_path / "mine.toml"))
    path = simulate(scene, Settings(method="dop853", rtol=1e-12, samples=7, estimate="off"))
    write_poses(path, list(scene.body_names), tmp_path / "mine.csv")
    words = [str(tmp_path / "mine.csv"), str(tmp_path / "mine.toml"), "--json"]
    done = CliRunner().invoke(main, ["judge", *words], prog_name="mbs-ref")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["verdict"] == "agrees"
    assert told["error"]["truth"].startswith("agreed: not certified")


def test_who_waits_for_a_truth_is_told_so(own_file, monkeypatch):
    said = []
    monkeypatch.setattr(command_file.console, "awaited", lambda what: said.append(what) or nullcontext())
    assert run(str(own_file), "pendulum").exit_code == 0
    (sentence,) = said
    assert sentence.startswith("computing the truth of pendulum")


def test_errors_of_zero_are_drawn_at_the_floor_of_a_logarithmic_axis(monkeypatch, tmp_path):
    drawn: dict[str, Any] = {}
    figure = SimpleNamespace(add_scatter=lambda **line: drawn.update({line["name"]: line}), to_html=lambda **_: "")
    monkeypatch.setattr(judge, "new_figure", lambda *titles, **logs: figure)
    curves = {"t": [0.0, 1.0, 2.5], "a": [0.0, None, 2e-3], "b": [0.0, 0.0, 0.0], "c": [1e-30, 3e-5, 0.0]}
    judge._draw(SimpleNamespace(curves=curves), tmp_path / "a.html")  # type: ignore[arg-type]
    assert {name: line["y"] for name, line in drawn.items()} == {"a": [1e-17, None, 2e-3], "c": [1e-17, 3e-5, 1e-17]}
    assert all(line["x"] == curves["t"] for line in drawn.values())
