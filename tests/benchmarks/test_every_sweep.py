"""A sweep over made-up answers: what a settled truth answered counts, in the order of the questions, timed or not."""

from __future__ import annotations

import random
from dataclasses import replace
from typing import Any

import pytest

from cross_checks.judge.answers import Answer
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import Cell, Verdict
from cross_checks.prices import sweep as sweeps
from cross_checks.prices import timing
from cross_checks.records.record import Record
from cross_checks.records.store import Store
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.settings import Settings

SCENE = scenes.make("pendulum")
METHODS = ("mbs_ref rk4", "mbs_ref euler", "mbs_ref dop853", "mbs_ref radau")


def run_of(method: str, step: float) -> Record:
    return Record(
        SCENE.name, dict(SCENE.parameters), "mbs_ref", method, {"step": step}, "success", times={"loop_s": step}
    )


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("worth", ["all", "some", "none"])
def test_a_sweep(monkeypatch, seed, worth):
    """A provisional answer is replaced by that of the settled truth; a method that never settles is left out."""
    chance, passes, timed, seen = random.Random(seed), [], [], []
    names = [name.split()[1] for name in METHODS]
    never, quick = chance.sample(names, 2)  # one waits for its truth; with a first look, one is found at once
    rough = {name: tuple(run_of(name, chance.random()) for _ in range(2)) for name in names}
    fine = {name: () if name == "euler" else tuple(run_of(name, chance.random()) for _ in range(3)) for name in names}

    def answers(runs: Any, wanted: Any, targets: Any, progress: Any, patient: bool) -> Any:
        passes.append((targets, patient))
        chosen = list(wanted)
        chance.shuffle(chosen)
        for settled in (False, True):
            for question in chosen:
                name = question.method.name
                if not settled or (name != never and (patient or name != quick)):
                    cell = Cell(SCENE.name, {}, "mbs_ref", name, Verdict.CANNOT, f"no {name}")
                    yield Answer(question, cell, (fine if settled else rough)[name], NoTruth(""), settled)

    def measured(store: Any, call: Any, scene: Any, record: Record) -> Record:
        timed.append(record)
        return replace(record, notes=("timed",))

    monkeypatch.setattr(sweeps, "answers", answers)
    monkeypatch.setattr(sweeps, "timed", measured)
    rules = {"all": None, "some": lambda records: records[1:3], "none": lambda records: []}
    with Store() as store:
        found = list(sweeps.sweep(Runs(store), SCENE, ["mbs_ref"], names, targets=(0.5,), seen=seen.append,
                                  worth=rules[worth]))  # fmt: skip
    patient = worth != "some" or len(passes) > 1
    assert passes == {"all": [((0.5,), True)], "none": [((0.5,), False), ((0.5,), True)]}.get(worth, passes)
    left_out = {never} | (set() if patient else {quick})
    order = [name for name in (question.name for question in sweeps.registry.get("mbs_ref").methods()) if name in names]
    records = [one for name in order if name not in left_out for one in (fine[name] or [None])]
    shown = [replace(one, notes=()) if one.status == "success" else None for one in found]
    assert shown == records
    refused = [one for one in found if one.status != "success"]
    assert [(one.method, one.status, one.message) for one in refused] == (
        [("euler", "cannot", "no euler")] if "euler" not in left_out else [])  # fmt: skip
    chosen = {"all": list(range(len(found))), "some": [1, 2], "none": []}[worth]
    assert [k for k, one in enumerate(found) if "timed" in one.notes] == chosen
    assert len(timed) == len(chosen)
    assert len(seen[-1]) == sum(len((rough if name in left_out else fine)[name]) or 1 for name in names)


def test_methods_that_are_chosen_are_the_only_ones_and_unknown_ones_are_named():
    offered = sweeps._offered(["mbs_ref"], ["rk4", "euler"])
    assert {method.name for _, method in offered if method} == {"rk4", "euler"}
    with pytest.raises(ValueError, match="method = rk5, rk6 is offered by none"):
        list(sweeps.sweep(Runs(), SCENE, ["mbs_ref"], ["rk6", "rk4", "rk5"]))


@pytest.mark.parametrize("again", [False, True])
def test_times_are_measured_of_what_the_store_lacks_and_all_again_where_requested(monkeypatch, again):
    runs, reported = [run_of("rk4", 0.1 * k) for k in range(1, 5)], []
    monkeypatch.setattr(timing, "machine", lambda: "box")
    monkeypatch.setattr(timing.Isolated, "__call__", lambda self, function, scene, engine, settings, held: (
        [*held, 9.0 + settings.step], 1.0))  # fmt: skip
    with Store() as store:
        for run in runs[:2]:
            store.keep_timings(timing._key(SCENE, run), "box", [7.0, 7.1, 7.2])
        found = timing.timed_all(store, runs, lambda done, total, what: reported.append((done, total)), again)
    assert found.keys() == {id(run) for run in runs}
    expected = [9.0 + run.settings["step"] if again or k > 1 else 7.0 for k, run in enumerate(runs)]
    assert [found[id(run)].times["loop_s"] for run in runs] == pytest.approx(expected)
    assert reported == [(k, 4 if again else 2) for k in range(4 if again else 2)]


def test_a_sample_is_the_loop_and_the_share_of_the_processor_while_it_ran(monkeypatch):
    path = type("Path", (), {"timing": type("Timing", (), {"loop_s": 0.25, "build_s": 9.0})})
    monkeypatch.setattr(timing.engines, "get", lambda name: type("E", (), {"run": lambda self, *given: path})())
    for clock, times in (("perf_counter", (1.0, 3.0)),):
        monkeypatch.setattr(timing.time, clock, iter(times).__next__)
    monkeypatch.setattr(timing, "processor_time", iter((5.0, 6.5)).__next__)
    assert timing.sample(SCENE, "mbs_ref", Settings()) == timing.Sample(0.25, 0.75)
