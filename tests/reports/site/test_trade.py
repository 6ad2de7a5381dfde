"""The plots of the gallery: every scene has one, or the sentence why it has none, within bounds on counted work."""

from __future__ import annotations

import pytest

from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store
from cross_checks.truths.truth import NoTruth, Truth
from mbs_ref import scenes
from reports.site import gallery as trade


@pytest.fixture
def runs(tmp_path):
    with Store(tmp_path / "runs.sqlite") as store:
        yield Runs(store)


def test_no_run_of_a_plot_takes_more_steps_than_its_bodies_leave(runs, tmp_path, monkeypatch):
    monkeypatch.setattr(trade, "entrants", lambda: ["mbs_ref"])
    monkeypatch.setattr(trade, "WORK", 900)
    asked = []
    original = runs.run
    monkeypatch.setattr(runs, "run", lambda *given: asked.append(original(*given)) or asked[-1])
    scene = scenes.make("pendulum_chain", links=3)
    assert trade.write_trade(runs, scene, tmp_path / "plot.html") == ""
    assert 0 < max(run.record.steps for run in asked) <= 300


def test_a_scene_beyond_the_bound_says_so_and_names_the_command_that_draws_it(runs, tmp_path, monkeypatch):
    monkeypatch.setattr(trade, "truth_of", lambda *_: pytest.fail("engines were asked"))
    told = trade._trade(runs, scenes.make("tracked_vehicle"), tmp_path)
    assert "25,000 steps of 37 bodies a run, more than 300,000 of both" in told
    assert "`mbs-ref sweep tracked_vehicle --plot tracked_vehicle.html`" in told


def test_a_scene_within_the_bound_gets_what_engines_agree_on(runs, monkeypatch):
    scene, agreed = scenes.make("bicycle"), NoTruth("asked")
    monkeypatch.setattr(trade, "truth_of", lambda *_: agreed)
    assert trade._plot_truth(runs, scene) is agreed


def test_a_certified_truth_is_taken_whatever_it_would_cost(runs):
    assert isinstance(trade._plot_truth(runs, scenes.make("android_vertebral", model="paper")), Truth)
