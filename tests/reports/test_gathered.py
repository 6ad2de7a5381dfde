"""How a report is brought up to date, and an ensemble shared: what each stage adds, and what an interruption leaves."""

from __future__ import annotations

import random
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cross_checks.judge.answers import Answer, Question
from cross_checks.judge.vocabulary import Cell, Verdict
from cross_checks.records.record import Record
from cross_checks.truths.truth import NoTruth
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Trajectory
from reports import gather, query, shared_ensemble
from reports.facts import scene_facts
from reports.facts.report_data import GROWING, INTERRUPTED, ReportData
from reports.gather import Gathering
from tests.reports.page.test_shown_figures import irregular

LABELS = ("pendulum", "kepler")


def gathering(**more: Any) -> Gathering:
    return Gathering("store", **{"scenes": LABELS} | more)  # type: ignore[arg-type]


@pytest.mark.parametrize("stop", [None, 0, 1])
def test_what_is_ranked_is_timed_and_the_others_stay(monkeypatch, stop):
    """Records that were timed take the place of their own; after Ctrl-C the runs stay as they were."""
    data = irregular(3)
    ranked = random.Random(1).sample(data.records, 5)
    times = {id(run): replace(run, times={"loop_s": 7.0}) for run in ranked}

    def timed_all(store: str, runs: list[Record], report: Any, again: bool) -> dict[int, Record]:
        assert (store, runs, again) == ("store", ranked, True)
        if stop is not None:
            raise KeyboardInterrupt
        return times

    monkeypatch.setattr(gather, "timed_all", timed_all)
    monkeypatch.setattr(gather, "contenders", lambda data: ranked)
    found = gathering(again=True).timed(replace(data, incomplete="still", state=GROWING))
    left = {} if stop is not None else times
    assert [id(one) for one in found.records] == [id(left.get(id(run), run)) for run in data.records]
    said = f"{INTERRUPTED} after the accuracy runs, before all was timed"
    assert (found.incomplete, found.state) == (("", "") if stop is None else (said, INTERRUPTED))


def test_capabilities_truths_films_and_extremes_are_those_of_the_scenes(monkeypatch):
    """Facts are kept under the key of their own scene; engines that are not asked for are left out."""
    seen: list[Any] = []
    monkeypatch.setattr(gather.facts, "truth_key", lambda scene: f"truth of {scene.name}")
    monkeypatch.setattr(gather.facts, "scene_key", lambda scene: f"scene {scene.name}")
    held = {"truth of kepler": SimpleNamespace(scene="kepler")}
    monkeypatch.setattr(gather.facts, "recall", lambda store, key, kind: held.get(key) if store == "store" else None)
    remembered = lambda store, key, kind, make: seen.append(key) or make() if store == "store" else None  # noqa: E731
    monkeypatch.setattr(gather.facts, "remembered", remembered)
    monkeypatch.setattr(gather.facts, "engine_keys", list)
    monkeypatch.setattr(gather, "scene_facts", lambda scene: SimpleNamespace(scene=scene.name))
    able = tuple(SimpleNamespace(engine=name, scenes=None) for name in ("exudyn", "mujoco"))
    monkeypatch.setattr(gather, "capabilities", lambda chosen: seen.append(list(chosen)) or able)
    extremes = tuple(SimpleNamespace(engine=name) for name in ("mujoco", "exudyn"))
    monkeypatch.setattr(Gathering, "extreme_cells", lambda self: extremes)
    steps: list[Any] = []
    for engines in ((), ("mujoco",)):
        found = gathering(engines=engines, progress=lambda *given: steps.append(given)).beyond(ReportData((), ()))
        assert [one.scene for one in found.truths] == ["kepler"]
        assert [one.scene for one in found.mechanisms] == list(LABELS)
        assert [one.engine for one in found.capabilities] == list(engines or ("exudyn", "mujoco"))
        assert [one.engine for one in found.extremes] == list(engines or ("mujoco", "exudyn"))
    assert seen[:2] == [f"scene {name}" for name in LABELS]
    assert seen[3] == list(gathering().shown)
    assert steps == [(0, 1, f"filming {label}") for label in gathering().shown] * 2


@pytest.mark.parametrize("stop", [False, True])
def test_studies_are_added_to_those_there_and_failures_are_said(monkeypatch, stop):
    def measure_all(store: str, result: dict[str, Any], keys: Any, report: Any, full: bool) -> list[str]:
        assert (store, keys, full) == ("store", ["key"], True)
        result["space"] = "measured"
        if stop:
            raise KeyboardInterrupt
        return ["section sky: why"]

    monkeypatch.setattr(gather, "measure_all", measure_all)
    monkeypatch.setattr(gather.facts, "engine_keys", lambda: ["key"])
    monkeypatch.setattr(gather, "every", lambda: dict.fromkeys("abc"))
    data: Any = ReportData((), (), studies={"trust": "held"})  # type: ignore[dict-item]
    found = gathering(full=True).studied(data)
    assert (found.studies, data.studies) == ({"trust": "held", "space": "measured"}, {"trust": "held"})
    said = f"{INTERRUPTED} after 2 of 3 studies" if stop else "section sky: why"
    assert (found.incomplete, found.state) == (said, INTERRUPTED if stop else "")


@pytest.mark.parametrize("stop", [None, 1, 2])
def test_verdicts_come_one_by_one_in_the_order_of_the_questions(monkeypatch, stop):
    """One is stored; the truth of a scene is kept once; kernels are compiled for engines that are asked alone."""
    built = [scenes.make(name) for name in LABELS]
    wanted = [Question(scene, engine, None) for scene in built for engine in ("exudyn", "mujoco")]
    held = gather.facts.Stored(Cell("pendulum", {}, "mujoco", "", Verdict.AGREES, "held"))
    kept: list[Any] = []
    monkeypatch.setattr(gather, "questions", lambda scenes, tasks: wanted)
    monkeypatch.setattr(gather, "tasks", list)
    monkeypatch.setattr(gather.facts, "stored_answers", lambda store, wanted, full: {wanted[1]: held})
    needed = [SimpleNamespace(engine=name) for name in ("exudyn", "drake")]
    monkeypatch.setattr(gather, "preparations", lambda store: needed)
    monkeypatch.setattr(gather, "truth_facts", lambda label, scene, truth: f"{label} {truth.reason}")
    monkeypatch.setattr(gather.facts, "truth_key", lambda scene: scene.name)
    monkeypatch.setattr(gather.facts, "keep", lambda store, key, kind, result: kept.append((key, result)))

    def settled(store: str, missing: Any, report: Any, call: Any, full: bool, preparations: Any) -> Any:
        assert (missing, preparations, full) == ([wanted[0], *wanted[2:]], needed[:1], True)
        for k, question in enumerate(reversed(missing)):
            if k == stop:
                raise KeyboardInterrupt
            cell = Cell(question.scene.name, {}, question.engine, "", Verdict.AGREES, f"cell {k}")
            run = Record(question.scene.name, {}, question.engine, "", {}, "success")
            yield Answer(question, cell, (run,), NoTruth(f"truth {k}"), True)

    monkeypatch.setattr(gather.facts, "settled_answers", settled)
    stages, states = gathering(full=True).judged(ReportData((), ())), []
    while True:
        try:
            there = next(stages)()
        except StopIteration as end:
            found = end.value
            break
        states.append(there.state)
        missing = 4 - len(there.cells)
        assert there.incomplete == f"still being computed: {missing} of 4 verdicts"
    count = 3 if stop is None else stop
    order = {("kepler", "mujoco"): 0, ("kepler", "exudyn"): 1, ("pendulum", "exudyn"): 2}
    reasons = ["held" if (q.scene.name, q.engine) == ("pendulum", "mujoco") else f"cell {order[q.scene.name, q.engine]}"
               for q in wanted if order.get((q.scene.name, q.engine), -1) < count]  # fmt: skip
    assert [cell.reason for cell in found.cells] == reasons
    assert len(found.records) == count
    assert states == [GROWING] * count
    said = "" if stop is None else f"{INTERRUPTED} after {count + 1} of 4 cells"
    assert (found.incomplete, found.state) == (said, INTERRUPTED if said else "")
    assert (
        kept == [("kepler", "kepler truth 0"), ("pendulum", "pendulum truth 2")][: 2 if count == 3 else min(count, 1)]
    )


def test_what_fails_to_be_filmed_says_why_and_orbits_are_cut_until_they_are_dense(monkeypatch):
    """A circle of n pictures a turn bulges by (1 - cos(pi/n))/2 of its size; a hundredth is too much."""
    asked: list[float] = []

    def run(scene: Any, settings: Settings) -> Trajectory:
        asked.append(scene.duration)
        angle = np.linspace(0.0, scene.duration, settings.samples or 0)
        out = np.stack((np.cos(angle), np.sin(angle)), axis=1)[:, None] * np.array([[[0.0], [5.0]]])
        rate = np.stack((-np.sin(angle), np.cos(angle)), axis=1)[:, None] * np.array([[[0.0], [5.0]]])
        return Trajectory(angle, out, np.zeros(out.shape[:2]), rate, np.zeros(out.shape[:2]))

    monkeypatch.setattr(scene_facts, "simulate", run)
    bodies = [SimpleNamespace(name=name) for name in "ab"]

    def made(duration: float, count: int = 2) -> Any:
        one = SimpleNamespace(
            bodies=bodies * (count // 2), joints=(), contacts=(), loads=(), name="orbit", duration=duration
        )
        one.model_copy = lambda update: made(update["duration"], count)
        return one

    monkeypatch.setattr(scene_facts, "is_apart", lambda scene: True)
    for turns in (1.0, 2.7, 2.9, 9.0):
        asked.clear()
        path, why = scene_facts.filmed(made(2.0 * np.pi * turns))
        shown = turns
        while 0.5 * (1.0 - np.cos(np.pi * shown / (scene_facts.PICTURES - 1))) > scene_facts.MOST_BULGE:
            shown *= 0.5
        assert (asked[-1], why) == (pytest.approx(2.0 * np.pi * shown), "")
        assert path is not None
    path, why = scene_facts.filmed(made(1.0, 122))
    assert (path, why) == (None, "Not filmed here: 122 bodies; `mbs-ref animate orbit -o film.gif` films it")
    failed = SimpleNamespace(ok=False, message="NaN")
    monkeypatch.setattr(scene_facts, "simulate", lambda scene, settings: failed)
    assert scene_facts.filmed(made(1.0)) == (None, "Not filmed: NaN")


@pytest.mark.parametrize(("stop", "kept"), [(None, 12), (2, 2), (0, 0)])
def test_a_shared_ensemble_is_made_in_parts_and_an_interrupted_one_is_its_beginning(monkeypatch, stop, kept):
    """Four parts a process at most, none empty; parts that came after a gap are left out."""
    design: Any = SimpleNamespace(n_runs=29, laws={}, count=None, seed=4)
    call: Any = SimpleNamespace(processors=3)
    clock = iter(np.arange(0.0, 99.0, 0.5))
    monkeypatch.setattr(shared_ensemble, "time", SimpleNamespace(perf_counter=lambda: next(clock)))

    def each(parts: list[Any], work: Any, call: Any) -> Any:
        order = [*range(kept), *range(kept + 1, len(parts))] if stop is not None else [*reversed(range(len(parts)))]
        for place in order[: len(order) if stop is None else len(order) - 1]:
            yield parts[place], SimpleNamespace(statuses=["ok"] * parts[place].n_runs, part=parts[place])
        if stop is not None:
            raise KeyboardInterrupt

    monkeypatch.setattr(shared_ensemble, "each", each)
    monkeypatch.setattr(shared_ensemble, "joined", lambda design, built, marks: (built, marks))
    steps: list[Any] = []
    words: Any = ("variants", design, "settings", call, lambda *given: steps.append(given))
    if not kept:
        with pytest.raises(KeyboardInterrupt):
            shared_ensemble.shared_ensemble(*words)
        return
    built, marks = shared_ensemble.shared_ensemble(*words)  # type: ignore[misc]
    ends = [(one.part.first, one.part.stop) for one in built]  # type: ignore[attr-defined]
    assert len(ends) == kept
    assert all(low < high for low, high in ends)
    assert [low for low, _ in ends] == [0, *(high for _, high in ends[:-1])]
    assert stop is not None or ends[-1][1] == 29
    assert [done for done, _ in marks] == [done for done, _ in steps]
    assert marks[-1][0] == (29 if stop is None else steps[-1][0])
    assert [seconds for _, seconds in marks] == [0.5 * (k + 1) for k in range(len(marks))]
    assert {total for _, total in steps} == {29}


def test_one_run_of_an_ensemble_at_a_time_in_each_process():
    asked: list[Any] = []
    shared_ensemble._made("v", "s", lambda *given: asked.append(given), "part")  # type: ignore[arg-type]
    assert asked == [(shared_ensemble.run_ensemble, "v", "part", "s", 1)]


def test_runs_of_a_cluster_are_those_of_its_scheduler(monkeypatch):
    assert isinstance(query.isolated([]), query.Isolated)
    function = scenes.make("pendulum")
    monkeypatch.setattr(query, "python_parts", lambda scene: ["a force"])
    with query.isolated([function], 3.0, 5.0) as call:
        assert call is query.direct
    monkeypatch.setattr(query, "isolated", lambda scenes, timeout, scheduler: nullcontext((scenes, timeout, scheduler)))
    with query.cluster("tcp://h:1") as call:
        assert call == ((), query.workers.TIMEOUT, "tcp://h:1")  # type: ignore[comparison-overlap]
    with query.cluster(None) as call:
        assert call is None
