"""The GitHub action, as a sample repository with an engine in it would run it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import yaml

from tests.cross_checks.conformance.test_conformance import small_engine

ACTION = Path(__file__).parents[3] / ".github" / "actions" / "conformance" / "action.yml"


def test_the_action_examines_a_sample_repositorys_engine_and_leaves_a_badge(tmp_path):
    action = yaml.safe_load(ACTION.read_text())
    (step,) = [step for step in action["runs"]["steps"] if step["name"] == "examine"]
    (tmp_path / "small_.py").write_text(small_engine())
    given = {name: value.get("default", "small_.py") for name, value in action["inputs"].items()}
    stated = {key: given[re.findall(r"inputs\.(\w+)", value)[0]] for key, value in step["env"].items()}
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    shell = ["bash", "-euo", "pipefail", "-c", step["run"]]
    done = subprocess.run(shell, cwd=tmp_path, env=os.environ | stated | {"PATH": path}, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    badge = json.loads((tmp_path / "conformance-badge.json").read_text())
    assert badge["schemaVersion"] == 1
    assert badge["color"] == "brightgreen"
    assert re.fullmatch(r"\d+ passed", badge["message"])
    assert json.loads((tmp_path / "conformance.json").read_text())["conforms"]


def test_the_action_installs_the_checkout_that_it_lies_in():
    install = yaml.safe_load(ACTION.read_text())["runs"]["steps"][0]["run"]
    folder = re.findall(r'"\$GITHUB_ACTION_PATH/([./]+)\[conformance\]"', install)[0]
    assert (ACTION.parent / folder / "pyproject.toml").resolve().is_file()
