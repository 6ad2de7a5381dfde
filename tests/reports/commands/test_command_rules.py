"""Rules of single commands: options that would do nothing are refused, answers and interruptions lose nothing."""

from __future__ import annotations

import json
from contextlib import nullcontext
from dataclasses import asdict, replace
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

from benchmarks import history
from cross_checks.conformance import cases, repeatability
from cross_checks.conformance.repeatability import WAYS
from cross_checks.prices import sweep
from cross_checks.records.lines import append, read
from reports import query
from reports.cli import main
from reports.studies.models import choice
from tests.benchmarks.test_figures_of_benchmarks import entries
from tests.reports.commands.test_trade_cli import PENDULUM, RECORD


def run(*words: str) -> Any:
    return CliRunner().invoke(main, list(words), prog_name="mbs-ref")


@pytest.mark.parametrize(("words", "message"), [
    (("contact", "-p", "angle=1"), "go with --instant"),
    (("contact", "--at", "1"), "go with --instant"),
    (("pick", "pendulum_chain", "-p", "links=2", "--models", "--error", "1e-3"), "without parameters of their own"),
])  # fmt: skip
def test_an_option_that_would_do_nothing_is_refused(monkeypatch, words, message):
    monkeypatch.setattr(choice, "choose", lambda *given: 1 / 0)  # which would take minutes
    done = run(*words)
    assert done.exit_code == 2, done.output
    assert message in " ".join(done.stderr.split())


@pytest.mark.parametrize(("engine", "way", "code"), [
    ("mbs_ref", "another order", 1), ("mbs_ref", "two threads", 0), ("exudyn", "at once", 0)])  # fmt: skip
def test_one_way_in_which_our_bits_differ_is_a_failure(monkeypatch, engine, way, code):
    row = {"engine": engine, "method": "m", "scene": "s", "setting": "", "stopped": "",
           "differs": dict.fromkeys(WAYS, 0.0) | {way: 1e-16}}  # fmt: skip
    monkeypatch.setattr(cases, "cases", lambda *given: [SimpleNamespace(name="one")])
    monkeypatch.setattr(repeatability, "measured", lambda *given: [row])
    assert run("repeatability", "--json").exit_code == code


def test_a_change_is_named_by_its_own_job(monkeypatch, tmp_path):
    made = entries([1.0, 2.0, 3.0, 4.0])
    append(tmp_path / "h.jsonl", made)
    monkeypatch.setattr(history, "change_points", lambda values: [2])
    printed = json.loads(run("history", "--file", str(tmp_path / "h.jsonl"), "--json").stdout)
    assert printed["chain"]["changes"] == [asdict(made[2])["made"]]


def test_a_sweep_goes_on_without_doubles_and_an_interrupted_one_keeps_what_is_not_timed(monkeypatch, tmp_path):
    made = [replace(RECORD, settings={"method": "rk4", "step": step}) for step in (0.1, 0.2, 0.3)]
    timed = [replace(one, times={"loop_s": 9.0}) for one in made]

    def interrupted(runs: Any, scene: Any, names: Any, methods: Any, report: Any, errors: Any, judged: Any, worth: Any):
        judged(made)
        yield timed[0]
        raise KeyboardInterrupt

    monkeypatch.setattr(query, "open_runs", lambda *given: nullcontext(SimpleNamespace()))
    monkeypatch.setattr(query.inputs, "engine_names", lambda chosen: ["mbs_ref"])
    monkeypatch.setattr(sweep, "sweep", interrupted)
    with pytest.raises(query.Interrupted, match="after 1 of 3 records") as caught:
        query.sweep_records(PENDULUM, (), (), tmp_path / "a.jsonl")
    assert caught.value.records == [timed[0], *made[1:]]
    monkeypatch.setattr(sweep, "sweep", lambda *given: iter(timed))
    assert query.sweep_records(PENDULUM, (), (), tmp_path / "a.jsonl") == timed
    assert [record.settings["step"] for record in read(tmp_path / "a.jsonl")[0]] == [0.1, 0.2, 0.3]
