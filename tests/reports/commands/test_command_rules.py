"""Rules of single commands: options that would do nothing are refused, answers and interruptions lose nothing."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from cross_checks.prices import sweep
from cross_checks.records.lines import read
from reports import query
from reports.cli import main
from reports.studies import models
from tests.reports.commands.test_trade_cli import PENDULUM, RECORD


def run(*words: str) -> Any:
    return CliRunner().invoke(main, list(words), prog_name="mbs-ref")


@pytest.mark.parametrize(("words", "message"), [
    (("contact", "-p", "angle=1"), "go with --instant"),
    (("contact", "--at", "1"), "go with --instant"),
    (("pick", "pendulum_chain", "-p", "links=2", "--models", "--error", "1e-3"), "without parameters of their own"),
])  # fmt: skip
def test_an_option_that_would_do_nothing_is_refused(monkeypatch, words, message):
    monkeypatch.setattr(models, "choose", lambda *given: 1 / 0)  # which would take minutes
    done = run(*words)
    assert done.exit_code == 2, done.output
    assert message in " ".join(done.stderr.split())


def test_a_sweep_goes_on_without_doubles_and_an_interrupted_one_keeps_what_is_not_timed(monkeypatch, tmp_path):
    made = [replace(RECORD, settings={"method": "rk4", "step": step}) for step in (0.1, 0.2, 0.3)]
    timed = [replace(one, times={"loop_s": 9.0}) for one in made]
    unsettled = replace(RECORD, method="radau")  # judged by a truth that is not settled: it is not timed

    def interrupted(runs: Any, scene: Any, names: Any, methods: Any, report: Any, errors: Any, judged: Any, worth: Any):
        judged([unsettled, *made])
        yield timed[0]
        raise KeyboardInterrupt

    monkeypatch.setattr(query, "open_runs", lambda *given: nullcontext(SimpleNamespace()))
    monkeypatch.setattr(query.inputs, "engine_names", lambda chosen: ["mbs_ref"])
    monkeypatch.setattr(sweep, "sweep", interrupted)
    with pytest.raises(query.Interrupted, match="after 4 runs, 1 of them timed") as caught:
        query.sweep_records(PENDULUM, (), (), tmp_path / "a.jsonl")
    assert caught.value.records == [unsettled, timed[0], *made[1:]]
    monkeypatch.setattr(sweep, "sweep", lambda *given: iter(timed))
    assert query.sweep_records(PENDULUM, (), (), tmp_path / "a.jsonl") == timed
    assert [record.settings["step"] for record in read(tmp_path / "a.jsonl")[0]] == [0.1, 0.2, 0.3]
