"""`mbs-ref extremes`: JSON lines, and Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from reports.cli import main

pytest.importorskip("rebound")


@pytest.mark.slow  # the forms of the answer: test_small_statements.py; its judge: test_extremes.py
def test_a_small_extreme_prints_a_line_of_json_a_cell():
    asked = ["extremes", "--json", "--only", "plunge", "--engine", "rebound"]
    found = CliRunner().invoke(main, asked, prog_name="mbs-ref")
    assert found.exit_code == 0, found.output
    cells = [json.loads(line) for line in found.stdout.splitlines()]
    assert {cell["method"] for cell in cells} >= {"ias15", "whfast"}
    assert {cell["extreme"] for cell in cells} == {"plunge"}
    assert all(cell["points"] for cell in cells)


@pytest.mark.slow
def test_shards_of_the_extremes_are_disjoint_and_complete():
    asked = ["extremes", "--json", "--only", "orbits", "--engine", "rebound", "--shard"]
    parts = [CliRunner().invoke(main, [*asked, f"{k}/3"], prog_name="mbs-ref") for k in (1, 2, 3)]
    found = [{json.loads(line)["extreme"] for line in part.stdout.splitlines()} for part in parts]
    assert sorted(name for part in found for name in part) == ["eccentricity", "orbit-count", "plunge"]
    assert CliRunner().invoke(main, [*asked, "4/3"], prog_name="mbs-ref").exit_code == 2


@pytest.mark.slow  # test_stopped.py and test_interrupt.py stop quicker commands
def test_ctrl_c_keeps_the_cells_and_leaves_no_process_behind(tmp_path: Path):
    kept = tmp_path / "cells.jsonl"
    words = ["extremes", "--engine", "rebound", "--only", "orbits", "-o", str(kept)]
    running = subprocess.Popen(
        [sys.executable, "-c", "from reports.cli import main; main()", *words], start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    end = time.monotonic() + 60.0
    while running.poll() is None and time.monotonic() < end and not (kept.exists() and kept.stat().st_size):
        time.sleep(0.02)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30.0)
    assert running.returncode == 4, said
    assert "interrupted after" in said
    assert "Traceback" not in said
    assert json.loads(kept.read_text().splitlines()[0])["engine"] == "rebound"
    while _is_there(running.pid):  # whoever adopts a dead child may take a moment to bury it
        assert time.monotonic() < end + 60.0
        time.sleep(0.02)


def _is_there(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
