"""The comparison of trees and the changes between records: places that no real run reaches within seconds."""

from __future__ import annotations

import io
import itertools
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks import method_table
from benchmarks.history import Entry, from_benchmarks, from_records
from benchmarks.record_changes import Change, Move, changes, median_ratio
from benchmarks.trees import regression, slowed, worker
from benchmarks.trees.regression import CASES, Finding
from cross_checks import engines
from cross_checks.judge import ladder, one_run
from cross_checks.prices.timing import Comparison, Pace, Sample
from cross_checks.records.record import Error, Record
from mbs_ref import scenes

JOB = ("job", "2026-01-01", "abc", "box")


def run(engine: str, loop: float, error: float, **more: Any) -> Record:
    known = Error(error, "exact", 0.0, None)
    return Record("pendulum", {}, engine, "rk4", {"step": loop}, "success", times={"loop_s": loop}, error=known, **more)


def test_each_engine_that_reaches_the_error_has_a_series_of_its_own():
    runs = [run("slow", 0.9, 1e-7), run("quick", 0.4, 5e-7), run("quick", 0.2, 9e-4), run("lame", 0.1, 1e-2)]
    found = from_records(runs, "pendulum", 1e-6, *JOB)
    series = "loop pendulum {} within 1e-06 of the scene"
    assert found == [Entry(*JOB, series.format("slow"), 0.9, "s", "slow rk4 step=0.9", 1e-7),
                     Entry(*JOB, series.format("quick"), 0.4, "s", "quick rk4 step=0.4", 5e-7)]  # fmt: skip


def test_an_entry_of_a_benchmark_has_its_name_and_its_own_loop_time_where_it_states_one():
    stats = {"min": 2.0}
    items = [("a", {}), ("b", {"loop_s": 0.5, "error": 1e-7}), ("c", {"loop_s": [0.5], "error_mps2": 3e-9})]
    data = {"benchmarks": [{"name": name, "stats": stats, "extra_info": more} for name, more in items]}
    figures = [("bench a", 2.0, None), ("bench b", 0.5, 1e-7), ("bench c", 2.0, 3e-9)]
    assert from_benchmarks(data, *JOB) == [Entry(*JOB, name, value, "s", "", error) for name, value, error in figures]


def test_two_calls_of_a_second_are_slow(monkeypatch):
    calls: list[str] = []
    monkeypatch.setattr(method_table, "_called", lambda scene, method, rtol: (calls.append(method) or 1.0, None))
    method_table._in_turns(None, ("a", 1.0), ("b", 1.0))  # type: ignore[arg-type]
    assert (calls.count("a"), calls.count("b")) == (1, 1)


def test_a_pendulum_is_tried_by_the_methods_of_its_core(monkeypatch):
    """Gauss is for particles alone; a point on a rod is no hinge, as Taylor series need."""
    tried: set[tuple[str, float]] = set()
    path = lambda scene, method, rtol: tried.add((method, rtol)) or SimpleNamespace(ok=True, method=method)  # noqa: E731
    monkeypatch.setattr(method_table, "FAR", float("inf"))
    monkeypatch.setattr(method_table, "_run", path)
    monkeypatch.setattr(method_table, "_error", lambda *given: 0.0)
    monkeypatch.setattr(method_table, "_in_turns", lambda scene, *keys: [1.0] * len(keys))
    assert len(list(method_table.rows("pendulum"))) == len(method_table.ASKED)
    decades = [10.0**-k for k in range(3, 13)]
    fixed = {(method, rtol) for method in ("dop853", "radau", "lsodar") for rtol in decades}
    assert tried == fixed | {("auto", rtol) for rtol in method_table.ASKED} | {("dop853", 1e-13), ("dop853", 1e-11)}


# record_changes


def test_a_median_of_ratios_leaves_out_what_is_unknown():
    known = [Change("run", Move.SAME, "", ratio) for ratio in (3.0, None, 1.0, None, 2.0)]
    assert median_ratio(known) == 2.0
    assert median_ratio(known[1:2]) is None


@pytest.mark.parametrize("gaps", [(None, 1e-3), (1e-3, None), (None, None)])
def test_a_gap_that_one_file_lacks_is_no_change(gaps):
    before, after = (replace(run("swing", 1.0, 1e-6), measures={"compliance_position": gap}) for gap in gaps)
    (one,) = changes([before], [after])
    assert (one.move, one.sentence, one.run) == (Move.SAME, "", "pendulum swing rk4 step=1.0")


def test_twice_the_error_is_the_same_and_a_run_without_settings_has_a_name_without_gaps():
    before, after = run("swing", 1.0, 2.0**-20), run("swing", 1.0, 2.0**-19)
    assert changes([before], [after])[0].move is Move.SAME
    (one,) = changes(*([replace(each, settings={})] for each in (before, after)))
    assert one.run == "pendulum swing rk4"


# regression


def finding(verdict: str, sentence: str = "") -> Finding:
    return Finding("case", verdict, sentence, 1e-6)


def test_pairs_that_all_differ_are_inconclusive_with_what_each_says():
    others = iter([finding("same", "why 2"), finding("faster", "why 3")])
    found = regression.confirmed(finding("slower", "why 1"), lambda: next(others))
    sentence = "pairs of processes disagree: slower: why 1; same: why 2; faster: why 3"
    assert found == finding("inconclusive", sentence)


def test_the_worst_verdict_stands_for_all():
    order = ["slower", "not measured", "inconclusive", "faster", "same"]
    for few in itertools.chain(*(itertools.permutations(order, count) for count in range(1, 6))):
        assert regression.overall([finding(word) for word in few]) == min(few, key=order.index)


def test_a_comparison_is_stated_of_its_case(monkeypatch):
    case, timing = replace(CASES[0], error=1e-5), Comparison(Pace.SAME, 1.0, 0.9, 1.1, 9, 0.12)
    rungs = [{"status": "success", "error": error, "settings": {"step": error}} for error in (None, 1e-4, 1e-5)]
    climbed: list[Any] = []
    tree: Any = SimpleNamespace(climb=lambda **given: climbed.append(given) or rungs, time=lambda **given: given)
    seen: list[Any] = []
    monkeypatch.setattr(regression, "compare", lambda one, other, seed: seen.append((one(), other(), seed)) or timing)
    found = regression.examine(tree, tree, case, 5)
    assert seen == [(case.what | {"settings": {"step": 1e-5}},) * 2 + (5,)]
    assert climbed == [case.what | {"method": case.method}] * 2
    sentence = "1.000 times the baseline's loop time [0.900, 1.100] to 1e-05 of the scene, 9 blocks"
    assert found == Finding(case.name, "same", f"{sentence}; 12% of the runs shared the machine", 1e-5, timing)
    rungs.pop()
    none = regression.examine(tree, tree, case)
    reason = "no setting of the baseline reaches 1e-05 of the scene"
    assert none == Finding(case.name, "not measured", reason, 1e-5)


def test_a_tree_is_a_script_of_its_own_with_pipes(monkeypatch):
    begun: list[Any] = []

    def popen(words: list[str], **more: Any) -> Any:
        begun.append((words, more))
        raise OSError("begun")

    monkeypatch.setattr(regression.subprocess, "Popen", popen)
    with pytest.raises(OSError, match="begun"):
        regression.Tree(slowed.HERE)
    ((words, more),) = begun
    assert words == [sys.executable, "-P", str(Path(worker.__file__))]
    pipes = [more[name] for name in ("stdin", "stdout", "stderr", "text")]
    assert pipes == [subprocess.PIPE, subprocess.PIPE, subprocess.DEVNULL, True]


def test_a_question_is_sent_before_its_answer_is_awaited(tmp_path):
    class Pipe(io.StringIO):
        sent = ""

        def flush(self) -> None:
            Pipe.sent = self.getvalue()

    tree = regression.Tree.__new__(regression.Tree)
    answer = lambda: Pipe.sent and json.dumps({"asked": json.loads(Pipe.sent)})  # noqa: E731
    tree.folder = tmp_path
    tree._child = SimpleNamespace(stdin=Pipe(), stdout=SimpleNamespace(readline=answer))  # type: ignore[assignment]
    assert tree.climb(scene="a") == {"asked": {"do": "climb", "scene": "a"}}  # type: ignore[comparison-overlap]


# slowed


@pytest.mark.parametrize(("measured", "turns"), [(0.0, [50, 500, 5000, 50000]), (1000.0, [50, 1, 1, 1])])
def test_a_tree_is_slowed_by_ten_times_as_much_at_most_and_by_one_turn_at_least(monkeypatch, tmp_path, measured, turns):
    made: list[int] = []
    monkeypatch.setattr(slowed, "slow_down", lambda folder, count: made.append(count))
    monkeypatch.setattr(slowed, "Tree", lambda folder: io.StringIO())
    monkeypatch.setattr(slowed, "excess", lambda before, after, case: measured)
    slowed.calibrate(tmp_path, CASES[0], 0.15)
    assert made == turns


def test_the_excess_is_that_of_the_fastest_runs_after_one_that_compiles():
    """Runs of the first tree take 9 s, then from 2 s; those of the second from 3 s."""

    def tree(least: float) -> Any:
        rungs = [{"status": "success", "error": 1e-9, "settings": {"step": 0.1}}]
        spans = itertools.chain([0.1], itertools.cycle([9.0, least, 5.0]))
        return SimpleNamespace(climb=lambda **_: rungs, time=lambda **_: Sample(next(spans)))

    assert slowed.excess(tree(2.0), tree(3.0), CASES[0]) == pytest.approx(0.5)
    lost: Any = SimpleNamespace(climb=lambda **_: [])
    with pytest.raises(ValueError, match=rf"no setting of {CASES[0].name} reaches 1e-06 of the scene"):
        slowed.excess(lost, lost, CASES[0])


# worker


def test_what_engines_print_goes_to_stderr_and_answers_to_the_first_stdout(monkeypatch):
    calls: list[Any] = []
    system = SimpleNamespace(
        dup=lambda n: ("copy of", n), fdopen=lambda *given: calls.append(given) or io.StringIO(),
        dup2=lambda *given: calls.append(given), path=worker.os.path,
    )  # fmt: skip
    monkeypatch.setattr(worker, "os", system)
    monkeypatch.setattr(worker.sys, "stdin", io.StringIO(""))
    worker.main()
    assert calls == [(("copy of", 1), "w"), (2, 1)]


def test_a_rung_that_fails_has_no_loop_and_the_next_is_tried(monkeypatch):
    failed = Record("pendulum", {}, "mbs_ref", "rk4", {"step": 1.0}, "failed")
    made = iter([failed, run("mbs_ref", 0.1, 1e-7)])
    monkeypatch.setattr(ladder, "rungs", lambda method, scene: [1.0, 0.1])
    monkeypatch.setattr(one_run, "evaluate", lambda *given: next(made))
    monkeypatch.setattr(engines, "get", lambda name: SimpleNamespace(method=lambda name: None))
    found = worker.climb("pendulum", {}, "mbs_ref", "rk4")
    assert found == [{"settings": {"step": 1.0}, "status": "failed", "error": None, "loop_s": None},
                     {"settings": {"step": 0.1}, "status": "success", "error": 1e-7, "loop_s": 0.1}]  # fmt: skip


def test_a_rate_is_measured_over_as_many_calls_as_fill_the_time(monkeypatch):
    """13.5 us a call, by a clock that shows 1 s before: 4^6 calls are the first that take a tenth of 0.5 s."""
    calls, clock = [], [1.0]

    def repeat(count: int) -> None:
        calls.append(count)
        clock[0] += 13.5e-6 * count

    monkeypatch.setattr(worker, "_rated", {("chain", "{}"): (repeat, 3)})
    monkeypatch.setattr(worker, "time", SimpleNamespace(process_time=lambda: clock[0]))
    assert worker.rate("chain", {}, 0.5) == {"ns_per_body": pytest.approx(4500.0)}
    assert calls == [4, 16, 64, 256, 1024, 4096, pytest.approx(0.5 / 13.5e-6, abs=1.0)]


def test_right_hand_sides_of_a_scene_are_repeated_in_compiled_code():
    repeat, bodies = worker.right_hand_sides(scenes.make("double_pendulum"))
    repeat(2)
    assert bodies == 2
