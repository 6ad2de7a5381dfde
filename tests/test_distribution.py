"""The wheel and the sdist hold all that runs, and the version stands in one place."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


def test_the_version_is_the_same_wherever_it_is_told():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    cited = next(line for line in (ROOT / "CITATION.cff").read_text().splitlines() if line.startswith("version:"))
    assert version("mbs-ref") == declared
    assert cited == f"version: {declared}"


def run(*words: str | Path, cwd: Path) -> str:
    done = subprocess.run([str(word) for word in words], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_a_distribution_installs_and_simulates_in_a_clean_environment(kind, tmp_path):
    tree = tmp_path / "tree"
    run("git", "clone", "--quiet", ROOT, tree, cwd=tmp_path)  # what is committed, and no build of yesterday
    call = f"import setuptools.build_meta as b; print(b.build_{kind}('{tmp_path}'))"
    name = run(sys.executable, "-c", call, cwd=tree).split()[-1]
    if kind == "wheel":
        held = zipfile.ZipFile(tmp_path / name).namelist()
        assert "cross_checks/truths/data/certificates/pendulum.json" in held
        assert not [file for file in held if file.startswith("tests/")]
    home = tmp_path / "clean"
    venv.create(home, with_pip=True)
    run(home / "bin" / "python", "-m", "pip", "install", "--quiet", tmp_path / name, cwd=tmp_path)
    told = run(home / "bin" / "mbs-ref", "simulate", "pendulum", "--t-end", "0.1", "--json", cwd=tmp_path)
    assert json.loads(told)["status"] == "success"
