"""Any signal that ends a command: what is known so far is printed, and the exit code is 4. Another method hangs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PATIENCE = 300.0  # s, the start of processes on a busy machine included
ADAPTER = '''
import time
from dataclasses import replace
from tests.cross_checks.conftest import Swing

class Halting(Swing):
    """The pendulum by two methods, of which one never ends."""

    name = "halting"

    def methods(self):
        second = super().methods()[0]
        return (replace(second, name="hangs"), second)

    def run(self, scene, settings, times=None):
        if settings.method == "hangs":
            time.sleep(3600.0)
        return super().run(scene, settings, times)

ENGINE = Halting
'''
# The best answer so far is printed at every tick. A shell may have left signals ignored.
CHILD = """
import signal
signal.signal(signal.SIGHUP, signal.SIG_DFL)
from reports import query as asking
asking.FIRST = 0.0
from reports.cli import main
main()
"""
WORDS = {"check": ["check", "pendulum", "--json"], "pick": ["pick", "pendulum", "--error", "1e-3", "--json"]}


@pytest.mark.parametrize(
    ("command", "stop", "words"),
    [
        ("check", signal.SIGTERM, "agrees"),
        pytest.param("pick", signal.SIGINT, "second step=", marks=pytest.mark.slow),
        pytest.param("check", signal.SIGHUP, "agrees", marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_what_is_known_is_printed(tmp_path, command, stop, words):
    adapter = tmp_path / "halting_.py"
    adapter.write_text(ADAPTER)
    asked = [*WORDS[command], "--engine", str(adapter), "--store", str(tmp_path / "runs.sqlite")]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": ROOT}
    path = os.environ | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen([sys.executable, "-c", CHILD, *asked], env=path, **pipes) as child:  # type: ignore[call-overload]
        assert child.stderr is not None
        assert any(words in line for line in iter(child.stderr.readline, ""))
        child.send_signal(stop)
        out, errors = child.communicate(timeout=PATIENCE)
    assert child.returncode == 4, errors
    assert "interrupted after" in errors
    _check_answer(json.loads(out), command)


def _check_answer(found, command: str) -> None:
    if command == "pick":
        assert found["best"]["method"] == "second"
    else:
        (cell,) = found
        assert (cell["method"], cell["verdict"], cell["settled"]) == ("second", "agrees", True)
