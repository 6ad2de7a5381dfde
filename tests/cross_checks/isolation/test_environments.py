"""An engine in an environment of its own: its packages and ours never meet, and its runs are runs like others."""

from __future__ import annotations

import sys
import zipfile
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cross_checks import engines
from cross_checks.engines.elsewhere import processor_time
from cross_checks.isolation import environments
from cross_checks.isolation.parent import Isolated
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store, run_name
from mbs_ref import scenes
from mbs_ref.scene import UserForce
from mbs_ref.settings import Settings
from reports.cli import main

ADAPTER = '''
"""Lets a point mass fall by what a package says, which has to be of version 2."""

from typing import ClassVar

import numpy as np
import toy_solver

from cross_checks.engine import Engine, Method, output_times
from mbs_ref.trajectory import Trajectory

toy_solver.only_in_version_2()


class Toy(Engine):
    name: ClassVar[str] = "toy"
    package: ClassVar[str] = "toy_solver"
    part_types: ClassVar[frozenset[str]] = frozenset({"point_mass", "user_force", "distance"})

    def methods(self):
        return (Method("exact", "adaptive", 8, "the parabola"),)

    def version(self):
        return toy_solver.__version__

    def run(self, scene, settings, times=None):
        t = output_times(scene, settings, times)
        if settings.rtol == 0.5:
            toy_solver.crash()
        place = np.zeros((len(t), 1, 2))
        place[:, 0, 1] = toy_solver.fallen(t)
        return Trajectory(t, place, np.zeros((len(t), 1)), 0.0 * place, np.zeros((len(t), 1)))


ENGINE = Toy
'''
SOLVER = """
import os, signal, time
__version__ = "2.0"
def only_in_version_2(): pass
def fallen(t):
    began = time.process_time()
    while time.process_time() < began + 0.1: pass
    return -0.5 * 9.81 * t * t
def crash(): os.kill(os.getpid(), signal.SIGKILL)
"""
SCENE = scenes.make("pendulum")
TIMES = np.linspace(0.0, 1.0, 3)


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """Put a toy engine's adapter where it is known, version 1 of its package here, and version 2 into a wheel."""
    here, wheel = tmp_path / "here", tmp_path / "toy_solver-2.0-py3-none-any.whl"
    here.mkdir()
    (here / "toy_solver.py").write_text('__version__ = "1.0"\n')
    (tmp_path / "toy_.py").write_text(ADAPTER)
    told = "toy_solver-2.0.dist-info"
    with zipfile.ZipFile(wheel, "w") as file:
        file.writestr("toy_solver.py", SOLVER)
        file.writestr(f"{told}/METADATA", "Metadata-Version: 2.1\nName: toy-solver\nVersion: 2.0\n")
        file.writestr(
            f"{told}/WHEEL", "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        file.writestr(f"{told}/RECORD", "")
    monkeypatch.syspath_prepend(here)
    monkeypatch.setenv(environments.FOLDER, str(tmp_path / "homes"))
    monkeypatch.setenv(engines.ADAPTERS, str(tmp_path / "toy_.py"))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    yield wheel
    engines._elsewhere.cache_clear()
    sys.modules.pop("toy_solver", None)


def test_runs_go_to_the_engines_own_packages_and_one_that_dies_costs_itself(toy):
    home = environments.make("toy", [], over=True)
    (environments._site_of(home) / "toy_solver.py").write_text(SOLVER)
    assert import_module("toy_solver").__version__ == "1.0"
    found = engines.get("toy")
    assert (found.version(), found.part_types >= {"point_mass"}) == ("2.0", True)
    own = processor_time()
    assert found.run(SCENE, Settings(), TIMES).position[-1, 0].tolist() == [0.0, -0.5 * 9.81]
    assert processor_time() - own >= 0.1  # s that the engine computes
    lost = found.run(SCENE, Settings(rtol=0.5), TIMES)
    assert (lost.status, "SIGKILL" in lost.message) == ("engine-error", True)
    assert found.run(SCENE, Settings(), TIMES).ok
    own = SCENE.model_copy(update={"loads": (UserForce(name="own", function=lambda t, q, v: 0.0 * q),)})
    assert "environment of its own" in found.run(own, Settings(), TIMES).message
    called = run_name(SCENE, found, Settings(), TIMES)
    found.made_of = "another adapter"
    assert run_name(SCENE, found, Settings(), TIMES) != called


@pytest.mark.slow
def test_an_engine_is_installed_apart_run_judged_and_forgotten(toy, tmp_path):
    with pytest.raises(AttributeError):  # a version that does not go with the adapter
        engines.get("toy")
    done = CliRunner().invoke(main, ["engines", "install", "toy", "--over", "--with", str(toy)])
    assert done.exit_code == 0, done.output
    assert "toy 2.0 lives in" in done.stdout
    assert set(environments.homes()) == {"toy"}
    with Store(tmp_path / "runs.sqlite") as store, Isolated() as call:
        runs = Runs(store, call)
        record = runs.run(SCENE, "toy", Settings()).record
        assert (record.status, record.engine, record.versions["toy"]) == ("success", "toy", "2.0")
        assert runs.held(SCENE, "toy", Settings()) is not None
    assert CliRunner().invoke(main, ["engines", "forget", "toy"]).exit_code == 0
    assert environments.homes() == {}


@pytest.mark.slow
def test_what_pip_refuses_leaves_nothing_noted(toy):
    done = CliRunner().invoke(main, ["engines", "install", "toy", "--over", "--with", "nowhere-to-be-found"])
    assert done.exit_code == 1
    assert "pip could not install nowhere-to-be-found" in done.stderr
    assert environments.homes() == {}


def test_an_environment_that_is_gone_is_an_engine_missing(toy):
    home = environments.make("toy", [], over=True)
    environments.python_of(home).unlink()
    with pytest.raises(engines.EngineMissing, match="is gone; mbs-ref engines install toy makes it anew"):
        engines.get("toy")


@pytest.mark.parametrize("name", ["mbs_ref", "mujuco"])
def test_only_engines_that_are_known_are_installed(toy, name):
    done = CliRunner().invoke(main, ["engines", "install", name])
    assert done.exit_code == 2
    assert "allowed: " in done.stderr


def test_a_folder_with_other_things_in_it_is_not_touched(toy, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("x")
    done = CliRunner().invoke(main, ["engines", "install", "toy", "--into", str(tmp_path / "mine")])
    assert done.exit_code == 2
    assert (tmp_path / "mine" / "thesis.tex").is_file()


def test_an_environment_sees_our_sources_and_none_of_our_packages(monkeypatch):
    around = environments.surroundings("toy")
    assert around["PYTHONPATH"] == str(environments.PROJECT)
    monkeypatch.setattr(environments, "PROJECT", Path(environments.sysconfig.get_path("purelib")))
    assert environments.surroundings("toy")["PYTHONPATH"] == ""


def test_an_environment_is_made_of_the_pinned_releases(toy, tmp_path, monkeypatch):
    pins = tmp_path / "pins"
    pins.mkdir()
    (pins / "toy.txt").write_text("toy-solver==1.0\n")
    monkeypatch.setattr(environments, "PINS", pins)
    assert environments.pins_of("another") is None
    with pytest.raises(environments.NotMade, match="pip could not install"):
        environments.make("toy", [str(toy)])  # its version 2.0 is not the pinned one
    assert environments.homes() == {}


def test_pins_are_exact_and_name_no_place():
    files = sorted(Path(environments.__file__).parent.glob("pins/*.txt"))
    assert files
    for file in files:
        assert file.stem in engines.names()
        for line in file.read_text().splitlines():
            name, _, release = line.partition("==")
            assert name, line
            assert release[:1].isdigit(), line


@pytest.mark.parametrize("name", sorted(file.stem for file in environments.PINS.glob("*.txt")))
def test_who_lacks_an_engine_with_pins_is_told_to_make_it_an_environment(monkeypatch, tmp_path, name):
    monkeypatch.setenv(environments.FOLDER, str(tmp_path))
    said = ""
    try:
        engines.get(name)
    except engines.EngineMissing as missing:
        said = str(missing)
    if not said:
        pytest.skip(f"{name} is installed here")
    assert f"(mbs-ref engines install {name})" in said
