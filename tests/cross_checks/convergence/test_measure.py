"""The measuring of classifiers, with trivial ones; the toy engine has the errors that it states."""

from __future__ import annotations

import numpy as np
import pytest

from cross_checks.engines import ADAPTERS, get
from cross_checks.judge.cell import judged
from cross_checks.judge.ladder import settings_at
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import Verdict
from mbs_ref import scenes
from tests.cross_checks.convergence import toy_engine
from tests.cross_checks.convergence.law import size
from tests.cross_checks.convergence.measure import evaluate, markdown, mistakes, report
from tests.cross_checks.convergence.synthetic import CALIBRATION

VERDICTS = {"correct": Verdict.AGREES, "wrong-limit": Verdict.WRONG_LIMIT, "never": Verdict.DIVERGED}
SEEDS = range(300)


def omniscient(method, seed):
    """Return the label itself after two runs."""
    for setting in (method.coarsest, method.finest):
        method.run(setting)
    return VERDICTS[method.label], {"wrong_limit": float(method.label == "wrong-limit")}, 2


def hasty(method, seed):
    """Call every method wrong on one run, at even odds."""
    method.run(method.coarsest)
    return Verdict.DIVERGED, {"wrong_limit": 0.5}, 1


def test_a_classifier_that_knows_the_labels_makes_no_mistake():
    judged = evaluate(omniscient, CALIBRATION, SEEDS)
    figures = report(judged)
    assert mistakes(judged) == []
    groups = figures["groups"]
    assert groups["correct"]["passed"] + groups["wrong-limit"]["called wrong"] + groups["never"]["called wrong"] == 300
    first, *_, last = figures["odds of a wrong limit"]
    assert (first["came true"], last["came true"]) == (0.0, 1.0)
    assert 0.6 < groups["wrong-limit, shown"]["methods"] / groups["wrong-limit"]["methods"] <= 1.0


def test_odds_that_do_not_come_true_are_reported():
    figures = report(evaluate(hasty, CALIBRATION, SEEDS))
    (even,) = [row for row in figures["odds of a wrong limit"] if row["count"]]
    assert (even["from"], even["stated"], even["within 2"]) == (0.3, 0.5, False)
    assert figures["called wrong on one run"] == figures["groups"]["correct"]["called wrong"]
    assert "| 0.3 to 0.7 |" in markdown(figures)


@pytest.fixture
def engine(monkeypatch):
    monkeypatch.setenv(ADAPTERS, toy_engine.__file__)
    monkeypatch.setenv(toy_engine.COUNT, "60")
    return get("toy_engine")


def test_runs_of_the_toy_engine_are_as_far_off_as_their_states(engine):
    scene = scenes.make("double_pendulum")
    runs, truth = Runs(), Runs().truth(scene)
    for method in engine.methods():
        toy = toy_engine.drawn(method.name)
        knob = toy.coarsest * 0.1 * (scene.duration / toy.duration if toy.kind == "fixed" else 1.0)
        settings = settings_at(method, scene, knob)
        record = runs.judged(scene, "toy_engine", settings, truth)
        outcome = toy.run(settings.rtol or settings.step * toy.duration / scene.duration)
        if outcome.state is None:
            assert record.status != "success"
        elif size(outcome.state - toy.limit) < 0.01 * toy.limit_distance:
            assert record.error.value == pytest.approx(size(outcome.state), rel=0.05)
        else:
            assert 0.03 < record.error.value / size(outcome.state) < 30.0
        assert record.steps == outcome.steps or record.status == "cannot"


def test_a_toy_engine_is_judged_through_the_public_interface(engine):
    scene = scenes.make("pendulum")
    (plain,) = [m for m in engine.methods() if m.description == "plain" and m.order == 4 and m.kind == "fixed"][:1]
    cell, _ = judged(Runs(), scene, "toy_engine", plain, Runs().truth(scene))
    assert cell.verdict is Verdict.AGREES


def test_displacements_vanish_at_the_start_and_have_their_velocities(engine):
    scene, toy = scenes.make("pendulum"), toy_engine.drawn("a3")
    times = np.linspace(0.0, scene.duration, 40 * 1000 + 1)
    shift, rate = toy_engine.displaced(scene, toy, np.ones(40), times).swapaxes(0, 1)
    assert max(size(shift[0]), size(rate[0])) < 1e-14
    slope = np.gradient(shift, times, axis=0)
    assert size(slope - rate) < 1e-3 * size(rate)
