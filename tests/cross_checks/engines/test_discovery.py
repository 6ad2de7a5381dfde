"""Engines are found by listing a folder and the entry points; only an absent package counts as missing."""

from __future__ import annotations

import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import EntryPoint

import pytest

from cross_checks import engines
from cross_checks.engine import Engine
from mbs_ref import scenes
from mbs_ref.settings import Settings


def test_the_folder_is_listed_with_the_reference_first():
    names = engines.names()
    assert names[0] == "mbs_ref"
    assert {"exudyn", "mujoco", "pinocchio"} <= set(names)
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("name", [n for n in engines.names()])
def test_each_engine_bears_its_name(name):
    try:
        found = engines.get(name)
    except engines.EngineMissing:
        pytest.skip(f"{name} is not installed")
    assert isinstance(found, Engine)
    assert found.name == name
    assert found.part_types


def test_an_unknown_engine_lists_the_allowed_and_suggests():
    with pytest.raises(ValueError, match=r"engine = 'mujuco' is unknown; did you mean 'mujoco'\?; allowed: mbs_ref, "):
        engines.get("mujuco")
    with pytest.raises(ValueError, match="engine = 'zzz' is unknown; allowed: "):
        engines.get("zzz")


def an_adapter(tmp_path, monkeypatch, text: str) -> None:
    (tmp_path / "strange_adapter.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "strange_adapter", raising=False)
    entry = EntryPoint("strange", "strange_adapter:Strange", engines.GROUP)
    monkeypatch.setattr(engines, "_entry_points", lambda: {"strange": entry})


def test_an_entry_point_is_an_engine(tmp_path, monkeypatch):
    an_adapter(tmp_path, monkeypatch, "class Strange:\n    name = 'strange'\n")
    assert "strange" in engines.names()
    assert engines.get("strange").name == "strange"


def test_what_an_engine_prints_when_it_is_imported_is_no_part_of_an_answer(tmp_path, monkeypatch, capsys):
    an_adapter(tmp_path, monkeypatch, "print('no warp')\nclass Strange:\n    name = 'strange'\n")
    engines.get("strange")
    assert capsys.readouterr() == ("", "no warp\n")


def test_what_an_engine_warns_of_in_its_loop_is_a_note_of_the_run(monkeypatch):
    pytest.importorskip("pinocchio")
    engine = engines.get("pinocchio")
    advance = type(engine).advance

    def warning(self, model, plan):
        for _ in range(2):
            warnings.warn("the iteration did not converge", RuntimeWarning, stacklevel=1)
        return advance(self, model, plan)

    monkeypatch.setattr(type(engine), "advance", warning)
    path = engine.run(scenes.make("pendulum"), Settings(method="rk4", step=1e-2, t_end=0.1, samples=2))
    assert path.ok
    assert path.notes.count("pinocchio warned: the iteration did not converge") == 1


def test_an_absent_package_of_its_own_is_engine_missing(tmp_path, monkeypatch):
    an_adapter(tmp_path, monkeypatch, "import not_there\nclass Strange:\n    package = 'not_there'\n")
    with pytest.raises(engines.EngineMissing, match="engine 'strange' needs the package 'not_there'"):
        engines.get("strange")
    assert issubclass(engines.EngineMissing, ImportError)


def test_any_other_failed_import_is_a_broken_adapter(tmp_path, monkeypatch):
    an_adapter(tmp_path, monkeypatch, "import other_thing\nclass Strange:\n    package = 'not_there'\n")
    with pytest.raises(ModuleNotFoundError, match="other_thing") as caught:
        engines.get("strange")
    assert not isinstance(caught.value, engines.EngineMissing)


def test_threads_that_need_an_adapter_at_once_wait_for_its_import(tmp_path, monkeypatch):
    """A search once met the half-imported adapter of a reference engine, and ended with an AttributeError."""
    an_adapter(tmp_path, monkeypatch, "import time\ntime.sleep(0.2)\nclass Strange:\n    name = 'strange'\n")
    with ThreadPoolExecutor(2) as pool:
        assert [made.name for made in pool.map(engines.get, ["strange", "strange"])] == ["strange", "strange"]
