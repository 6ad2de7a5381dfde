"""Progress in a log: a line now and then, with what is done, the time so far and what is under way."""

from __future__ import annotations

import pytest

from reports import console
from reports.commands.engines import conformance
from reports.console import Lines
from reports.query import reporting


@pytest.fixture
def clock(monkeypatch) -> list[float]:
    now = [0.0]
    monkeypatch.setattr(console.time, "monotonic", lambda: now[0])
    return now


def test_a_line_every_few_seconds_with_the_time_so_far(clock, capsys):
    report = Lines("report")
    for done in range(11):
        clock[0] = float(done)
        report(done, 100, f"cell {done}")
    lines = capsys.readouterr().err.splitlines()
    assert [line.split()[1] for line in lines] == ["3/100", "6/100", "9/100"]
    assert lines[-1] == "report: 9/100 after 9 s cell 9"


def test_the_best_so_far_is_printed_once_it_is_known_and_when_its_time_has_doubled(clock, capsys):
    best = [""]
    report = reporting(lambda *_: None, lambda: best[0])
    for now, text in ((19.0, "early"), (20.0, ""), (21.0, "first"), (41.0, "again"), (42.0, "second"), (83.0, "late")):
        clock[0], best[0] = now, text
        report(0, 1)
    assert capsys.readouterr().err.splitlines() == ["So far, after 21 s: first", "So far, after 42 s: second"]


@pytest.mark.parametrize("is_terminal", [True, False])
def test_an_examination_overwrites_one_line_of_a_terminal_and_writes_none_to_a_log(monkeypatch, capsys, is_terminal):
    monkeypatch.setattr(conformance.sys.stderr, "isatty", lambda: is_terminal, raising=False)
    conformance._progress("pendulum by rk4")
    assert tuple(capsys.readouterr()) == ("", f"\r{'pendulum by rk4':<60}" if is_terminal else "")
