"""A sweep that is killed at any moment loses no record and doubles none when it goes on."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cross_checks.records.lines import key_of, read

KILLS = 20
SWEEP = "from reports.cli import main; main()"
WORDS = ["sweep", "pendulum", "--engine", "mbs_ref", "--method", "rk4", "--method", "euler", "--method", "dop853"]


def sweep(file: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", SWEEP, *WORDS, "-o", str(file)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip


def keys(file: Path) -> list[str]:
    records, problems = read(file)
    assert all("no record" in problem for problem in problems)  # a torn line is named, skipped and made again
    return sorted(key_of(record) for record in records)


@pytest.mark.slow
def test_killed_twenty_times(tmp_path, capsys):
    assert sweep(tmp_path / "warm.jsonl").wait() == 0  # compiles
    began = time.monotonic()
    assert sweep(tmp_path / "whole.jsonl").wait() == 0
    took, expected = time.monotonic() - began, keys(tmp_path / "whole.jsonl")
    moments, begun = random.Random(8), [tmp_path / "killed_0.jsonl"]
    kills = partial = 0
    while kills < KILLS:
        child = sweep(begun[-1])
        time.sleep(moments.uniform(0.2, 1.0) * took)
        alive = child.poll() is None
        child.kill()
        child.wait()
        kills += alive
        held = keys(begun[-1]) if begun[-1].exists() else []
        assert len(held) == len(set(held))
        partial += alive and 0 < len(held) < len(expected)
        if len(held) == len(expected):  # another, to be killed again
            begun.append(tmp_path / f"killed_{len(begun)}.jsonl")
    for file in begun:
        assert sweep(file).wait() == 0
        assert keys(file) == expected
    with capsys.disabled():
        print(f"\n{kills} kills, {partial} of them with records written and records missing; {len(begun)} sweeps of "
              f"{len(expected)} records: none lost, none doubled")  # fmt: skip
