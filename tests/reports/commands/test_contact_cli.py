"""mbs-ref contact: JSON of a translation, and errors that name what is wrong."""

import json
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import pytest
from click.testing import CliRunner

from reports.cli import main

GOOD = {"--rebound": "0.5", "--friction": "0.7", "--stiffness": "1e5", "--mass": "2"}


def contact(**changed: str):
    words = [word for pair in (GOOD | {f"--{name}": value for name, value in changed.items()}).items() for word in pair]
    return CliRunner().invoke(main, ["contact", *words, "--json"])


def test_json_states_what_was_requested_obtained_and_refused():
    pytest.importorskip("mujoco")
    result = contact(engine="mujoco")
    assert result.exit_code == 0, result.output
    (line,) = result.stdout.splitlines()
    answer = json.loads(line)
    assert answer["request"]["mass"] == 2.0
    figures = {row["figure"]: row for row in answer["figures"]}
    assert figures["restitution"]["requested"] == 0.5
    assert figures["restitution"]["obtained"] == pytest.approx(0.5, rel=0.02)
    assert figures["creep, m/s"]["note"].startswith("cannot")
    assert 'solref="-50000 ' in answer["snippet"]


@pytest.mark.parametrize(
    ("changed", "words", "code"),
    [
        ({"rebound": "1.2"}, "rebound = 1.2", 2),
        ({"mass": "0"}, "mass = 0", 2),
        ({"engine": "foo"}, "engine = 'foo'", 2),
    ],
)
def test_a_bad_request_is_an_error_that_names_it(changed, words, code):
    result = contact(**changed)
    assert result.exit_code == code
    assert words in result.output


def test_a_missing_figure_is_named():
    result = CliRunner().invoke(main, ["contact", "--rebound", "0.5"])
    assert result.exit_code == 2
    assert "--friction, --stiffness, --mass must be given" in result.output


def test_an_instant_of_a_scene_with_a_parameter_is_assessed_at_a_time(tmp_path):
    pytest.importorskip("mujoco")
    file = tmp_path / "instant.npz"
    words = ["--scene", "sliding_block", "-p", "height=0", "--at", "0.1", "--engine", "mujoco", "--json"]
    result = CliRunner().invoke(main, ["contact", "--instant", str(file), *words])
    assert result.exit_code == 0, result.output
    assert file.is_file()
    assert [json.loads(line)["engine"] for line in result.stdout.splitlines()][:2] == ["mbs_ref", "mujoco"]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--instant", "x.npz", "--scene", "sliding_block", "--at", "-1"], "--at -1: must be at least 0"),
        (["--figures", "-p", "height=0"], "--at and -p go with --instant FILE --scene SCENE"),
        (["--tosses", "--folder", "."], "no file of a toss"),
        (["--tosses", "--scene", "incline"], "--scene goes with --figures, --holding or --instant"),
        (["--tosses", "--holding"], "--figures, --holding or --instant, and --tosses exclude each other"),
        (["--instant", "x.npz"], "--instant takes one scene"),
    ],
)
def test_options_that_do_not_fit_are_named(words, complaint, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(main, ["contact", "--engine", "mujoco", *words])
    assert result.exit_code == 2
    assert complaint in result.output


@dataclass
class Prediction:
    """Any row of a table."""

    name: str
    value: float


@pytest.mark.parametrize("holding", [True, False])
def test_an_instant_is_of_a_scene_that_is_named_or_of_a_block_that_friction_holds(monkeypatch, tmp_path, holding):
    """A block has its own time, the start."""
    asked: list[Any] = []
    row = Prediction("a", 0.25)
    monkeypatch.setattr("cross_checks.contact.models", lambda names: ({"mujoco": "model"}, []))
    monkeypatch.setattr("cross_checks.contact.by_figure.holding", lambda: {"steep": "a block", "flat": "another"})
    monkeypatch.setattr("reports.inputs.scene", lambda name, parameters: f"the scene {name}")
    monkeypatch.setattr("cross_checks.contact.instant.state_at", lambda scene, at: (scene, at))
    monkeypatch.setattr("cross_checks.contact.instant.instant", lambda state, step: (*state, step))
    monkeypatch.setattr("cross_checks.contact.instant.write", lambda problem, path: asked.append((problem, path)))
    monkeypatch.setattr("cross_checks.contact.instant.assess", lambda problem, models: [row])
    file = tmp_path / "a.npz"
    words = ["--holding"] if holding else ["--at", "0.5"]
    result = CliRunner().invoke(main, [
        "contact", "--instant", str(file), "--scene", "flat", "--step", "1e-4", "--json", *words])  # fmt: skip
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout) == {"name": "a", "value": 0.25}
    assert asked == [(("another", 0.0, 1e-4) if holding else ("the scene flat", 0.5, 1e-4), file)]


KINDS = (("--figures",), ("--holding",), ("--instant", "x.npz"), ("--tosses",), ("--folder", "."))


@pytest.mark.parametrize("words", [(*one, *other) for one, other in combinations(KINDS, 2)])
def test_kinds_of_comparisons_exclude_each_other(monkeypatch, words):
    """But the instant is of a block that friction holds, and a folder holds tosses."""
    reached: list[Any] = []
    monkeypatch.setattr("cross_checks.contact.models", lambda names: ({"mujoco": "model"}, []))
    monkeypatch.setattr("cross_checks.contact.by_figure.holding", dict)
    monkeypatch.setattr("reports.commands.choose.contact._violations", lambda *given: reached.append(given) or [])
    noted = lambda *given, **more: reached.append(given) or []  # noqa: E731
    monkeypatch.setattr("reports.commands.choose.contact._predictions", noted)
    done = CliRunner().invoke(main, ["contact", *words])
    together = {"--holding", "--instant"} <= {*words} or {"--tosses", "--folder"} <= {*words}
    assert (done.exit_code, bool(reached)) == ((5, True) if together else (2, False))
    assert together or "exclude each other" in done.stderr
