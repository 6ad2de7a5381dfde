"""A sweep or a report that is killed at any moment loses nothing, doubles nothing and resumes to the same results."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cross_checks.records.lines import key_of, read
from reports.commands.publish.show import last_report

KILLS = 20
COMMAND = [sys.executable, "-c", "from reports.cli import main; main()"]
SWEEP = ["sweep", "pendulum", "--engine", "mbs_ref", "--method", "rk4", "--method", "euler", "-o"]
OUT = {"sweep": "out.jsonl", "report": "out"}  # a file, a folder
# without its limit of processor time, which decides by the clock what is computed
REPORT = ["report", "--scene", "pendulum", "--engine", "mbs_ref", "--target", "1e-3", "--full", "-o"]


def swept(place: Path) -> list[Any]:
    """Return the keys of the records; a torn line is named, skipped and computed again."""
    records, problems = read(place / OUT["sweep"]) if (place / OUT["sweep"]).exists() else ([], [])
    assert all("no record" in problem for problem in problems)
    return sorted(key_of(record) for record in records)


def reported(place: Path) -> list[Any]:
    """Return every cell with its runs: whatever does not depend on the clock."""
    if not (place / OUT["report"] / "index.html").exists():
        return []
    data = last_report(place / OUT["report"])
    assert len(set(map(key_of, data.records))) == len(data.records)
    runs = [(key_of(r), r.status, r.error, r.steps, r.rhs_calls, r.measures) for r in data.records]
    cells = [(c.label, c.engine, c.method, c.verdict, c.error, c.order, [t.answer for t in c.targets])
             for c in data.cells]  # fmt: skip
    return sorted(map(repr, runs + cells))


def begin(words: list[str], place: Path) -> subprocess.Popen[bytes]:
    place.mkdir(exist_ok=True)
    kept = os.environ | {"MBS_REF_STORE": str(place / "store.sqlite")}
    return subprocess.Popen([*COMMAND, *words, str(place / OUT[words[0]])], env=kept,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("words", "held"), [(SWEEP, swept), (REPORT, reported)], ids=["sweep", "report"])
def test_killed_twenty_times(words: list[str], held: Callable[[Path], list[Any]], tmp_path, capsys):
    assert begin(words, tmp_path / "warm").wait() == 0  # compiles
    began = time.monotonic()
    assert begin(words, tmp_path / "whole").wait() == 0
    took, expected = time.monotonic() - began, held(tmp_path / "whole")
    moments, places = random.Random(8), [tmp_path / "killed_0"]
    kills = partial = 0
    while kills < KILLS:
        child = begin(words, places[-1])
        time.sleep(moments.uniform(0.2, 1.0) * took)
        alive = child.poll() is None
        child.kill()
        child.wait()
        kills += alive
        found = held(places[-1])
        assert len(found) == len(set(found))
        partial += alive and 0 < len(found) < len(expected)
        if len(found) == len(expected):  # another, to be killed again
            places.append(tmp_path / f"killed_{len(places)}")
    for place in places:
        assert begin(words, place).wait() == 0
        assert held(place) == expected
    with capsys.disabled():
        print(f"\n{kills} kills, {partial} of them with results written and results missing; {len(places)} runs of "
              f"{len(expected)} results: none lost, none doubled")  # fmt: skip
