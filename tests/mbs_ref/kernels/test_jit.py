"""Compiled code is kept under a digest of all its sources, wherever the function is written."""

import ast
import os
import subprocess
import sys
import types
from pathlib import Path

import pytest

from mbs_ref.kernels.jit import _Index, sources_of

ROOT = Path(__file__).parents[3]
FORCE = "from mbs_ref.kernels.jit import jit\n\n@jit\ndef twice(x):\n    return {factor} * x\n\nprint(twice(3.0))\n"


def _printed(command: list[str], folder) -> str:
    own = os.environ | {"MBS_REF_CACHE": str(folder), "PYTHONPATH": os.pathsep.join(sys.path)}
    ended = subprocess.run([sys.executable, *command], env=own, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout.strip()


@pytest.mark.slow  # two processes of its own
def test_a_script_may_compile_and_its_changes_are_seen(tmp_path):
    script = tmp_path / "own_force.py"
    for factor in (2.0, 3.0):
        script.write_text(FORCE.format(factor=factor))
        assert _printed([str(script)], tmp_path / "cache") == f"{3.0 * factor}"
    kept = list(tmp_path.rglob("*twice*.nbi"))
    assert len({path.parent for path in kept}) == 2  # a digest each


def test_code_without_a_file_compiles_and_is_not_kept(tmp_path):
    assert _printed(["-c", FORCE.format(factor=4.0)], tmp_path) == "12.0"
    assert not list(tmp_path.rglob("*.nbi"))


KERNELS = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts) for path in (ROOT / "mbs_ref" / "kernels").rglob("[!_]*.py")
)


@pytest.mark.parametrize("module", KERNELS)
def test_code_is_kept_under_a_digest_of_every_module_that_it_imports(module):
    """Under another name too: code that kept its place after a change of what it asks ended the process."""
    tree = ast.parse((ROOT / Path(*module.split("."))).with_suffix(".py").read_text())
    named = [
        f"{node.module}.{name.name}" for node in tree.body if isinstance(node, ast.ImportFrom) for name in node.names
    ]
    named += [node.module for node in tree.body if isinstance(node, ast.ImportFrom) if node.module]
    ours = {name for name in named if (ROOT / Path(*name.split("."))).with_suffix(".py").is_file()}
    assert ours <= sources_of(module)


def test_a_public_name_is_code_of_the_module_that_it_comes_from(tmp_path, monkeypatch):
    (tmp_path / "user_of_names.py").write_text("from mbs_ref import Scene, Trajectory, scenes\n")
    monkeypatch.syspath_prepend(tmp_path)
    reached = sources_of("user_of_names")
    assert {"mbs_ref", "mbs_ref.scene.scene", "mbs_ref.trajectory", "mbs_ref.scenes"} <= reached
    assert "mbs_ref.simulate.one_run" not in reached  # offered by the same stub, and not imported


def test_code_compiled_for_types_of_another_checkout_is_no_code(tmp_path, monkeypatch):
    elsewhere = types.ModuleType("a_checkout_that_is_gone")
    elsewhere.Kind = type("Kind", (), {"__module__": elsewhere.__name__, "__qualname__": "Kind"})
    monkeypatch.setitem(sys.modules, elsewhere.__name__, elsewhere)
    index = _Index(str(tmp_path), "twice", "stamp")
    index.save(elsewhere.Kind, b"code")
    assert index.load(elsewhere.Kind) == b"code"
    monkeypatch.delitem(sys.modules, elsewhere.__name__)
    assert index.load("another") is None
    index.save("another", b"own")
    assert index.load("another") == b"own"
