"""A sweep that is killed at any moment loses no record and doubles none when it goes on."""

from __future__ import annotations

import random
import subprocess
import sys
import time

import pytest

from cross_checks.record_file import key_of, read

KILLS = 20
SWEEP = "from reports.cli import main; main()"
WORDS = ["sweep", "pendulum", "--engine", "mbs_ref", "--method", "rk4", "--method", "euler", "--method", "dop853"]


def sweep(file):
    return subprocess.Popen([sys.executable, "-c", SWEEP, *WORDS, "-o", str(file)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip


@pytest.mark.slow
def test_killed_twenty_times(tmp_path):
    whole, file = tmp_path / "whole.jsonl", tmp_path / "killed.jsonl"
    began = time.monotonic()
    assert sweep(whole).wait() == 0
    took = time.monotonic() - began
    moments = random.Random(8)
    for _ in range(KILLS):
        child = sweep(file)
        time.sleep(moments.uniform(0.3, 1.0) * took)
        child.kill()
        child.wait()
    assert sweep(file).wait() == 0
    expected, found = (sorted(key_of(r) for r in read(path)[0]) for path in (whole, file))
    assert found == expected
