"""A choice put to the test on a tiny engine whose clock is known."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cross_checks import engines
from cross_checks.judge.cell import truth_of
from cross_checks.judge.runs import Runs
from cross_checks.prices.pick import Bounds, afresh, as_shipped, duel, pick, settled, shipped
from cross_checks.prices.sweep import sweep
from cross_checks.prices.timing import Comparison, Pace
from mbs_ref import scenes
from mbs_ref.settings import Settings

PENDULUM = scenes.make("pendulum")


@pytest.fixture
def choice(swing):
    """The biased method is off by 0.25 m and, by its clock, as slow as the other at equal steps."""
    records = list(sweep(Runs(), PENDULUM, ["swing"], ["second", "biased"]))
    return pick(records, 0.5)


def found(pace: Pace, ratio: float) -> Comparison:
    return Comparison(pace, ratio, 0.9 * ratio, 1.1 * ratio, 10, 0.0)


def test_a_duel_times_the_runner_up_over_the_best(choice):
    steps = [record.settings["step"] for record in (choice.best, choice.runner_up)]
    outcome = duel(PENDULUM, choice)  # the engine's clock says its step
    assert outcome.ratio == pytest.approx(steps[1] / steps[0])
    with pytest.raises(ValueError, match="no runner-up"):
        duel(PENDULUM, replace(choice, runner_up=None))


def test_what_the_duel_leaves(choice):
    kept = settled(choice, found(Pace.SLOWER, 1.2))
    assert (kept.best, kept.margin) == (choice.best, 1.2)
    assert "Confirmed by 10" in kept.sentence
    turned = settled(choice, found(Pace.FASTER, 0.5))
    assert (turned.best, turned.runner_up, turned.margin) == (choice.runner_up, choice.best, 2.0)
    assert "Overturned" in turned.sentence
    assert "A tie" in settled(choice, found(Pace.SAME, 1.0)).sentence


def test_a_setting_run_afresh_meets_what_it_met(choice, swing):
    again = afresh(PENDULUM, choice.best, truth_of(Runs(), PENDULUM))
    assert Bounds(0.5).met_by(again)
    assert not Bounds(1e-9).met_by(again)
    swing(lambda path: replace(path, position=path.position + 1.0))
    assert not Bounds(0.5).met_by(afresh(PENDULUM, choice.best, truth_of(Runs(), PENDULUM)))


def test_an_engine_as_it_comes_is_held_against_the_truth_at_its_own_steps(swing, monkeypatch):
    assert as_shipped(Runs(), PENDULUM, "swing") is None  # it tells nothing

    def absent(name: str):
        raise engines.EngineMissing(f"engine {name!r} is not installed")

    with monkeypatch.context() as without:
        without.setattr(engines, "get", absent)
        assert as_shipped(Runs(), PENDULUM, "swing") is None
    own = type(engines.get("swing"))
    monkeypatch.setattr(own, "as_shipped", Settings(method="second", step=0.03))
    record = as_shipped(Runs(), PENDULUM, "swing")
    assert record is not None
    assert record.status == "success"
    assert record.settings["step"] == 0.03
    assert record.error is not None
    assert shipped(record).startswith("swing as it comes (second step=0.03): ")
