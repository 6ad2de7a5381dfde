"""Answers side by side: provisional ones while a truth is refined, settled ones after, and who is not waited for."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from cross_checks import engines
from cross_checks.isolation.parent import Isolated
from cross_checks.isolation.workers import Late, Over, Pool
from cross_checks.judge import answers as module
from cross_checks.judge.answers import Preparation, answers, check, questions
from cross_checks.judge.cell import tasks
from cross_checks.judge.consensus import Pair
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import Verdict
from cross_checks.records.store import Store
from cross_checks.truths import truth_for
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.scene.toml import read_scene

DATA = Path(__file__).parents[2] / "data"
PENDULUM = scenes.make("pendulum")


@pytest.fixture
def asked(swing):
    return questions([PENDULUM], tasks(["swing", "absent"]))


class Agreeing:
    """A consensus of which a test says the truths, one a request."""

    truths: tuple[tuple[float, bool], ...] = ()

    def __init__(self, pool, runs, scene, reason, enough):
        self.scene, self.enough, self.left = scene, enough, list(self.truths)
        self.pair, self.is_settled, self.pool = None, False, pool
        pool.add(module.Request(self, "swing", None, 0), lambda call: None, 5.0)  # type: ignore[arg-type]

    def receive(self, request, result):
        known_to, self.is_settled = self.left.pop(0)
        self.pair = Pair(known_to, None, None)  # type: ignore[arg-type]
        truth = truth_for(PENDULUM, np.linspace(0.0, PENDULUM.duration, 41))
        self.truth = replace(truth, kind="agreed", uncertainty=known_to, turn_uncertainty=known_to,
                             rate_uncertainty=np.full(41, known_to))  # fmt: skip
        if not self.is_settled:
            self.pool.add(request, lambda call: None, 5.0)


def test_answers_are_provisional_until_the_truth_is_settled(asked, monkeypatch):
    monkeypatch.setattr(module, "Consensus", Agreeing)
    monkeypatch.setattr(Agreeing, "truths", ((1e-2, False), (1e-5, False), (1e-5, False), (1e-12, True)))
    monkeypatch.setattr(Runs, "truth", lambda self, scene: NoTruth("no closed form"))
    seen = []
    found = list(answers(Runs(), asked, progress=lambda done, total, text: seen.append((done, total))))
    second = [(one.cell.verdict, one.is_settled) for one in found if one.question.method is asked[0].method]
    assert second == [(Verdict.BELOW_TRUTH, False), (Verdict.AGREES, True)]
    assert {t.target for t in found[2].cell.targets} == {1e-3, 10.0 * 1e-5}  # no finer than the truth is known
    assert {one.question for one in found if one.is_settled} == set(asked)
    assert seen[0] == (2, 4)  # loops and absent, which run nothing
    assert seen[-1] == (4, 4)


def test_a_certified_truth_gives_settled_answers_alone(asked):
    found = list(answers(Runs(), asked))
    assert len(found) == len(asked)
    assert all(one.is_settled for one in found)
    assert found[-1].records


@pytest.mark.parametrize("held", ["swing", "absent"])
def test_questions_wait_for_the_preparation_of_their_engine_alone(asked, monkeypatch, held):
    seen: list[str] = []
    judged, works = module.judged, [Preparation(held, "one", lambda call: seen.append("one")),
                                    Preparation(held, "two", lambda call: seen.append("two"))]  # fmt: skip
    monkeypatch.setattr(module, "judged", lambda *given: (seen.append(given[2]), judged(*given))[1])
    found = list(answers(Runs(), asked, preparations=works))
    assert {one.question for one in found} == set(asked)
    searched = [name for name in seen if name == "swing"]
    assert seen == (["one", "two", *searched] if held == "swing" else [*searched, "one", "two"])


def test_a_preparation_that_fails_leaves_the_failure_to_the_runs(asked):
    def fails(call):
        raise OSError("no space left on device")

    found = list(answers(Runs(), asked, preparations=[Preparation("swing", "compiling", fails)]))
    assert {one.question for one in found} == set(asked)


@pytest.mark.parametrize("patient", [True, False])
def test_a_method_that_comes_late_is_answered_last_or_not_at_all(asked, monkeypatch, patient):
    tried, judged = [], module.judged

    def once_late(runs, scene, engine, method, truth, targets):
        tried.append(method.name)
        if tried == ["second"]:
            raise Late("slow")
        return judged(runs, scene, engine, method, truth, targets)

    monkeypatch.setattr(module, "judged", once_late)
    monkeypatch.setattr(module, "Pool", Caught)
    found = [one.cell.method for one in answers(Runs(), asked, patient=patient)]
    assert found == ["loops", "", "biased", *(["second"] if patient else [])]


def test_what_the_time_does_not_suffice_for_is_missing_in_a_cell_and_classifies_none(swing):
    """Whatever the run that is not made, of a method that agrees and of one that is wrong."""

    class Limited(Runs):
        left = 0

        def run(self, *given):
            if self.left == 0:
                raise Over("would take 7 s")
            self.left -= 1
            return super().run(*given)

    truth = truth_for(PENDULUM, np.linspace(0.0, PENDULUM.duration, 41))
    assert truth is not None
    for method in ("second", "biased"):
        whole, _ = module.judged(Runs(), PENDULUM, "swing", engines.get("swing").method(method), truth)
        for left in range(len(whole.runs) + 1):
            runs = Limited()
            runs.left = left
            cell, records = module.judged(runs, PENDULUM, "swing", engines.get("swing").method(method), truth)
            if len(records) == len(whole.runs):
                assert cell.verdict is whole.verdict
                continue
            assert cell.verdict in {Verdict.NOT_SHOWN, Verdict.AGREES, Verdict.CONVERGING, Verdict.BELOW_TRUTH}
            assert cell.verdict is not Verdict.NOT_SHOWN or "would take 7 s" in cell.reason
            for result in cell.targets:
                assert result.answer in ("reached", "unjudged") or "would take 7 s" in result.reason


class Caught[Name, Result](Pool[Name, Result]):
    """A pool whose tasks give a Late here as they do in another process."""

    def add(self, name, work, seconds=0.0, tries=0):
        super().add(name, partial(_caught, work), seconds, tries)


def _caught(work, call):
    try:
        return work(call)
    except Late as late:
        return late


@pytest.mark.slow
def test_blind_runs_of_one_package_confirm_no_method():
    """Every run misses some of the stud's hits at its own times, which two runs at the same times would agree to."""
    scene = read_scene(DATA / "stud_and_stone.toml")
    verdicts = {cell.verdict for cell in check(Runs(Store(), Isolated()), [scene], ["mbs_ref"])}
    assert Verdict.NOT_SHOWN in verdicts
    assert verdicts <= {Verdict.NOT_SHOWN, Verdict.CANNOT}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["dumbbell_on_incline", "singular_peaucellier"])
def test_mechanisms_without_a_closed_form_get_a_truth_of_two_packages(name):
    found = list(answers(Runs(Store(), Isolated()), questions([read_scene(DATA / f"{name}.toml")], tasks(["mbs_ref"]))))
    assert any(not one.is_settled for one in found)
    truths = {one.truth.kind for one in found if one.is_settled and one.truth is not None}
    assert truths == {"agreed"}
