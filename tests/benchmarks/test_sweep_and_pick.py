"""Sweeps and picks with a tiny engine whose cost and error are known."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from click.testing import CliRunner

from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import OURS
from cross_checks.prices.pick import pick
from cross_checks.prices.sweep import sweep
from mbs_ref import scenes
from reports.cli import main
from tests.cross_checks.conftest import Swing, register

PENDULUM = scenes.make("pendulum")


@pytest.fixture(scope="module")
def records():
    with pytest.MonkeyPatch.context() as patch:
        register(Swing(), patch)
        return list(sweep(Runs(), PENDULUM))


def test_a_sweep_meets_every_decade_and_censors_nothing(records):
    by_method = {m: [r for r in records if r.method == m] for m in ("second", "biased", "loops", "")}
    errors = [r.error.value for r in by_method["second"]]
    assert all(any(10.0**-k / 10.0 <= e <= 10.0**-k for e in errors) for k in range(3, 8))
    assert by_method["loops"][0].status == "cannot"
    assert by_method[""][0].status == "engine-missing"
    assert all(r.times["loop_runs"] >= 1.0 for r in by_method["second"] if r.status == "success")


def test_unknown_methods_are_refused(swing):
    with pytest.raises(ValueError, match="sceond"):
        list(sweep(Runs(), PENDULUM, methods=["sceond"]))


def priced(records):
    """The finer, the dearer: cost 1 ms over the step in 0.1 s; the biased one costs a tenth."""
    return [
        replace(r, times={"loop_s": 1e-4 / r.settings["step"] * (0.1 if r.method == "biased" else 1.0)})
        for r in records
        if r.status == "success"
    ]


def test_the_cheapest_that_reaches_the_error_is_picked(records):
    choice = pick(priced(records), 1e-3)
    reaching = [r for r in priced(records) if r.error.bound <= 1e-3]
    assert choice.best == min(reaching, key=lambda r: r.times["loop_s"])
    assert choice.best.method == "second"
    assert choice.runner_up is None
    rough = pick(priced(records), 0.5)
    assert {rough.best.method, rough.runner_up.method} == {"biased", "second"}
    assert rough.margin == pytest.approx(rough.runner_up.times["loop_s"] / rough.best.times["loop_s"])


def test_the_runner_up_is_of_another_engine_and_our_own_solver_is_named_as_such(records):
    chance = random.Random(11)
    of = [(engine, method) for engine in (OURS, "exudyn", "mujoco") for method in ("rk4", "euler", "radau")]
    for _ in range(30):
        own = [replace(priced(records)[0], engine=engine, method=method, times={"loop_s": chance.uniform(0.1, 9.0)})
               for engine, method in of]  # fmt: skip
        choice = pick(own, 1.0)
        first, *others = sorted(own, key=lambda r: r.times["loop_s"])
        assert choice.best == first
        assert choice.runner_up == next(r for r in others if r.engine != first.engine)
        assert ("this project's own solver" in choice.sentence) == (first.engine == OURS)


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        ({"error": 1e-12}, ["none reached 1.0e-12 of the scene", "second step="]),
        ({"error": 1e-3, "budget": 1e-3}, ["none within 1 ms", "second step="]),
        ({"error": 1e-3, "compliance": 1e-9}, ["none keeps the constraints"]),
    ],
)
def test_the_sentence_when_none_did(records, bounds, words):
    choice = pick(priced(records), **bounds)
    assert choice.best is None
    assert all(word in choice.sentence for word in words), choice.sentence


def test_bounds_and_records_are_checked(records):
    with pytest.raises(ValueError, match=r"error = -1"):
        pick(records, -1.0)
    other = [replace(r, scene="other") for r in records]
    with pytest.raises(ValueError, match="2 scenes"):
        pick([*records, *other], 1.0)
    assert "no run" in pick([], 1.0).sentence


def test_where_nothing_was_measured_the_engines_answers_are_told():
    done = CliRunner().invoke(main, ["pick", "solar_system", "--error", "1e-3", "--engine", "mujoco"])
    assert done.exit_code == 5
    assert "no run with a known error was measured; mujoco: mujoco" in done.output
