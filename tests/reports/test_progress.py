"""Progress in a log: a line now and then, with what is done, what comes next and how long the rest may take."""

from __future__ import annotations

import pytest

from reports.terminal import console
from reports.terminal.console import Lines


@pytest.fixture
def clock(monkeypatch) -> list[float]:
    now = [0.0]
    monkeypatch.setattr(console.time, "monotonic", lambda: now[0])
    return now


def test_a_line_every_few_seconds_with_the_time_left(clock, capsys):
    report = Lines("report")
    for done in range(11):
        clock[0] = float(done)
        report(done, 100, f"cell {done}")
    lines = capsys.readouterr().err.splitlines()
    assert [line.split()[1] for line in lines] == ["3/100", "6/100", "9/100"]
    assert lines[-1] == "report: 9/100 cell 9, 9 s so far, about 91 s left of this"


def test_a_new_stage_is_foretold_from_its_own_pace(clock, capsys):
    report = Lines("report")
    report(9, 10, "slow")
    clock[0] = 100.0
    report(0, 50, "quick")
    clock[0] = 104.0
    report(4, 50, "quick")
    assert "about 46 s left" in capsys.readouterr().err.splitlines()[-1]
