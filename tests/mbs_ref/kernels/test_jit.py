"""Compiled code is kept under a digest of all its sources, wherever the function is written."""

import os
import subprocess
import sys

import pytest

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
