"""What a person types becomes numbers in SI units, disjoint parts, limits of runs, and nothing else."""

from __future__ import annotations

import random
from types import SimpleNamespace

import click
import pytest
from click.testing import CliRunner
from scipy import constants

from cross_checks.isolation.parent import Isolated
from cross_checks.judge.runs import Runs
from mbs_ref import scenes
from mbs_ref.scene.scales import scales_of
from mbs_ref.settings import Settings
from reports import inputs, query
from reports.cli import main
from reports.console import NothingSelected

LENGTHS = {"m": 1.0, "cm": constants.centi, "mm": constants.milli, "um": constants.micro, "nm": constants.nano,
           "km": constants.kilo}  # fmt: skip
TIMES = {"": 1.0, "s": 1.0, "ms": constants.milli, "us": constants.micro, "min": constants.minute}
FILE = """
name = "hung"
gravity = [0.0, -9.81]
[parameters]
length = { default = 0.5 }
mass = { default = 1.0 }
[[bodies]]
type = "point_mass"
name = "bob"
mass = "= mass"
position = [0.0, "= -length"]
velocity = [0.0, 0.0]
"""


@pytest.mark.parametrize("unit", LENGTHS)
def test_a_length_is_an_error_over_the_scenes_length(unit):
    scene = scenes.make("double_pendulum", length_1=3.7)
    length = scales_of(scene).length
    assert length != pytest.approx(1.0)
    for text, value in (("0.3", 0.3), ("2e-3", 2e-3), ("7", 7.0)):
        assert inputs.relative_error(f"{text}{unit}", scene) == pytest.approx(value * LENGTHS[unit] / length, rel=1e-12)
        assert inputs.relative_error(text, scene) == value
    assert inputs.LENGTHS.keys() == LENGTHS.keys()


@pytest.mark.parametrize("text", ["-1", "0mm", "nan", "inf", "1inch", "mm", "", "1e", "1 2"])
def test_what_is_no_error_is_refused(text):
    with pytest.raises(click.UsageError, match="is not understood"):
        inputs.relative_error(text, scenes.make("pendulum"))


@pytest.mark.parametrize("unit", TIMES)
def test_a_duration_in_seconds(unit):
    for text, value in (("50", 50.0), ("0.25", 0.25), ("1e-3", 1e-3)):
        assert inputs.seconds(f"{text}{unit}") == pytest.approx(value * TIMES[unit], rel=1e-12)
    assert inputs.SECONDS.keys() == TIMES.keys()


@pytest.mark.parametrize("seed", range(5))
def test_parts_are_disjoint_and_together_everything(seed):
    chance = random.Random(seed)
    items = [chance.random() for _ in range(chance.randint(6, 20))]
    count = chance.randint(1, 6)
    parts = [inputs.shard(items, f"{k}/{count}") for k in range(1, count + 1)]
    assert sorted(one for part in parts for one in part) == sorted(items)
    assert max(map(len, parts)) - min(map(len, parts)) <= 1
    for text in (f"0/{count}", f"{count + 1}/{count}", "1", "a/b"):
        with pytest.raises(click.UsageError, match="must be I/N with 1 <= I <= N"):
            inputs.shard(items, text)
    with pytest.raises(NothingSelected, match=f"99/99 of {len(items)} is empty"):
        inputs.shard(items, "99/99")


def test_words_become_numbers_where_they_are_some():
    words = ("a=3", "b=-2.5e-3", "c=true", "d=false", "e=front", "f=1.0", "g=a=b")
    found = inputs._parameters(words)
    assert found == {"a": 3, "b": -2.5e-3, "c": True, "d": False, "e": "front", "f": 1.0, "g": "a=b"}
    assert [type(value) for value in found.values()] == [int, float, bool, bool, str, float, str]


@pytest.mark.parametrize("words", [(), ("length=2.5",), ("length=2.5", "mass=3.0")])
def test_what_a_scene_is_made_with_stays_where_other_parameters_change(words):
    scene = inputs.scene("pendulum", words)
    rebuild = inputs.rebuilder("pendulum", scene)
    assert rebuild
    assert rebuild() == scene
    assert rebuild(gravity=1.625).parameters == {**scene.parameters, "gravity": 1.625}


@pytest.mark.parametrize("words", [(), ("length=2.5",), ("length=2.5", "mass=3.0")])
def test_what_a_file_is_read_with_stays_where_other_parameters_change(tmp_path, words):
    file = str(tmp_path / "hung.toml")
    (tmp_path / "hung.toml").write_text(FILE)
    scene = inputs.scene(file, words)
    rebuild = inputs.rebuilder(file, scene)
    assert rebuild
    assert rebuild() == scene
    given = dict(word.split("=") for word in words)
    lighter = rebuild(mass=0.25)
    assert lighter.parameters["length"] == float(given.get("length", 0.5))
    assert (lighter.bodies[0].mass, lighter.bodies[0].position[1]) == (0.25, -lighter.parameters["length"])


def test_limits_of_runs_are_seconds_and_mebibytes(monkeypatch):
    found = query.isolated((), 7.0, 3.0)
    assert (found.timeout, found.memory) == (7.0, 3 * 1024**2)
    usual = query.isolated(())
    assert (usual.timeout, usual.memory) == (Isolated().timeout, Isolated().memory)
    given: list[tuple[float, float, str]] = []

    def opened(built, store, timeout, memory, scheduler):
        given.append((timeout, memory, store))
        raise click.UsageError("opened")

    monkeypatch.setattr(query, "open_runs", opened)
    words = ("sweep", "pendulum", "--timeout", "9", "--memory", "5", "--store", "a.sqlite")
    assert "opened" in CliRunner().invoke(main, words).stderr
    assert given == [(9.0, 5.0, "a.sqlite")]


@pytest.mark.parametrize("named", [None, "mine.sqlite"])
def test_runs_are_stored_where_it_is_said(monkeypatch, tmp_path, named):
    monkeypatch.setenv("MBS_REF_STORE", str(tmp_path / "usual.sqlite"))
    chosen = None if named is None else str(tmp_path / named)
    with query.open_runs((), chosen) as runs:
        assert isinstance(runs, Runs)
        assert runs.store.path == tmp_path / (named or "usual.sqlite")


def test_a_start_is_compared_to_the_tolerance_of_every_run(monkeypatch):
    asked: list[float] = []
    monkeypatch.setattr(inputs, "broken_start", lambda scene, tolerance: asked.append(tolerance) or "it breaks rod")
    with pytest.raises(click.UsageError, match=r"pendulum: it breaks rod, which engines would repair differently"):
        inputs.comparable("pendulum")
    assert asked == [Settings().initial_tolerance]


def test_a_package_whose_import_is_barred_is_not_there(monkeypatch, tmp_path):
    def barred(name: str) -> None:
        raise ValueError(name)

    for found, there in ((lambda name: name, True), (lambda name: None, False), (barred, False)):
        monkeypatch.setattr(inputs, "find_spec", found)
        if there:
            assert inputs.output(str(tmp_path / "a.parquet"), (".parquet",)) == tmp_path / "a.parquet"
        else:
            with pytest.raises(click.UsageError, match="Parquet needs the package pyarrow"):
                inputs.output(str(tmp_path / "a.parquet"), (".parquet",))


def test_a_start_file_and_parameters_go_together(monkeypatch, tmp_path):
    """What a start states is read first, and parameters that are named beside it count."""
    file, start = tmp_path / "a.urdf", tmp_path / "s.toml"
    for one in (file, start):
        one.write_text("")
    asked: list[object] = []
    robot = SimpleNamespace(scene="scene", assumed=("no damping",))
    monkeypatch.setattr("cross_checks.robots.read_start", lambda path: ({"a": 1.0, "b": 2.0}, {"drive": path.name}))
    monkeypatch.setattr("cross_checks.robots.driven", lambda scene, drives, path: (scene, drives, path))
    monkeypatch.setattr(inputs, "_reader", lambda name: lambda path, wanted: asked.append((path, wanted)) or robot)
    assert inputs.scene(str(file), [f"start={start}", "b=7"]) == ("scene", {"drive": "s.toml"}, start)  # type: ignore[comparison-overlap]
    assert inputs.scene(str(file), ["b=7"]) == "scene"  # type: ignore[comparison-overlap]
    assert asked == [(file, {"a": 1.0, "b": 7}), (file, {"b": 7})]
