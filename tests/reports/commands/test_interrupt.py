"""Ctrl-C, sent to a real process: what was computed is kept, and the exit code is 4."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

PATIENCE = 300.0  # s, compilation on a busy machine included
# A shell may have left SIGINT ignored. The child says on stderr when its loop has come back to Python once,
# or, where runs have a process of their own, when the first is asked for.
CHILD = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from mbs_ref.integrators.loop.leg import Pace
from cross_checks.isolation.parent import Isolated
def announced(inner):
    def announce(*arguments):
        print("running", file=sys.stderr, flush=True)
        return inner(*arguments)
    return announce
Pace.is_hopeless = announced(Pace.is_hopeless)
Isolated.__call__ = announced(Isolated.__call__)
from reports.cli import main
main()
"""
LONG = ["simulate", "pendulum", "--method", "rk4", "--step", "1e-5", "--t-end", "90",
        "--samples", "90001", "--json"]  # fmt: skip


def begin(*words: str, store: Path | None = None) -> subprocess.Popen[str]:
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    kept = {} if store is None else {"MBS_REF_STORE": str(store)}
    return subprocess.Popen([sys.executable, "-c", CHILD, *words], env=os.environ | kept, **pipes)


def interrupt(child: subprocess.Popen[str]) -> tuple[str, str]:
    child.send_signal(signal.SIGINT)
    return child.communicate(timeout=PATIENCE)


def after_it_runs(child: subprocess.Popen[str], seconds: float = 0.5) -> tuple[str, str]:
    assert child.stderr is not None
    for line in child.stderr:
        if line.startswith("running"):
            break
    time.sleep(seconds)
    return interrupt(child)


def test_a_run_keeps_its_outputs(tmp_path):
    file = tmp_path / "poses.npz"
    child = begin(*LONG, "-o", str(file))
    out, errors = after_it_runs(child, 0.0)
    assert child.returncode == 4, errors
    record = json.loads(out)
    assert record["status"] == "interrupted"
    assert 0.0 < record["t_end"] < 90.0
    assert record["steps"] > 0
    assert "interrupted at t =" in record["message"]
    assert np.load(file)["times"][-1] == record["t_end"]


@pytest.mark.slow
def test_a_sweep_keeps_its_records(tmp_path):
    file = tmp_path / "records.jsonl"
    child = begin("sweep", "pendulum", "--engine", "mbs_ref", "-o", str(file))
    wait_for_a_line(file)
    _, errors = interrupt(child)
    assert child.returncode == 4, errors
    assert "interrupted after" in errors
    assert all(json.loads(line) for line in file.read_text().splitlines())


def wait_for_a_line(file: Path) -> None:
    end = time.monotonic() + PATIENCE
    while not (file.exists() and file.read_bytes().endswith(b"\n")):
        assert time.monotonic() < end, "no record came"
        time.sleep(0.02)


@pytest.mark.slow
def test_a_check_shows_its_cells(tmp_path):
    child = begin("check", "pendulum", "--engine", "mbs_ref", "--json", store=tmp_path / "runs.sqlite")
    out, errors = after_it_runs(child)
    assert child.returncode == 4, errors
    assert isinstance(json.loads(out), list)
    assert "interrupted after" in errors


@pytest.mark.slow
def test_a_report_shows_what_there_is(tmp_path):
    child = begin("report", "--quick", "-o", str(tmp_path / "out"), store=tmp_path / "runs.sqlite")
    _, errors = after_it_runs(child, 2.0)
    assert child.returncode == 4, errors
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert "<strong>Incomplete:</strong> interrupted after" in page
