"""Ratios and choices of the benchmark suites and of the comparison of trees, from made-up times."""

from __future__ import annotations

import ast
import io
import json
import random
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from statistics import median
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.suites import bench_batch, bench_growth, bench_peers, bench_rhs, bench_timing
from benchmarks.trees import regression, slowed, worker
from cross_checks import engines
from cross_checks.judge import ladder, one_run
from cross_checks.prices.timing import Comparison, Pace, Sample
from cross_checks.records.record import Error, Record
from mbs_ref import scenes
from mbs_ref.settings import Settings
from mbs_ref.trajectory import Timing


@pytest.mark.parametrize("seed", range(2))
def test_a_change_alone_is_confirmed_by_trees_started_afresh(monkeypatch, seed):
    verdicts = ["same", "faster", "inconclusive", "slower", "not measured"]
    random.Random(seed).shuffle(verdicts)
    found = [regression.Finding(verdict, verdict, "", None) for verdict in verdicts]
    given = iter(found)
    monkeypatch.setattr(regression, "Tree", lambda folder: nullcontext(folder))
    monkeypatch.setattr(regression, "examine", lambda *asked: next(given))
    monkeypatch.setattr(regression, "confirmed", lambda finding, afresh: f"{finding.verdict} confirmed")
    listed = list(regression.regressions(Path("a"), Path("b"), list("abcde")))  # type: ignore[arg-type]
    expected = [f"{one.verdict} confirmed" if one.verdict in ("faster", "slower") else one for one in found]
    assert listed == expected


def test_ours_is_held_against_the_fastest_peer(monkeypatch):
    """Loops and whole calls of one of ours and two peers: the least of all turns counts."""
    made = {"mbs_ref a": [(3.0, 9.0), (2.0, 8.0)], "mbs_ref b": [(4.0, 7.0), (5.0, 6.0)],
            "quick": [(8.0, 12.0), (7.0, 11.0)], "slow": [(90.0, 99.0), (80.0, 98.0)]}  # fmt: skip
    turns = {name: iter(times) for name, times in made.items()}
    runs = {name: lambda name=name: next(turns[name]) for name in made}
    monkeypatch.setattr(bench_peers, "loop", lambda *given: (np.zeros((1, 2)), (1.0, 1.0)))
    monkeypatch.setattr(bench_peers, "entrants", lambda *given: runs)
    benchmark = SimpleNamespace(extra_info={}, pedantic=lambda turn, **more: (turn(), turn()))
    bench_peers.test_over_the_best_peer(benchmark, "chain 3")
    assert benchmark.extra_info["of_loop"] == pytest.approx(2.0 / 7.0)
    assert benchmark.extra_info["of_call"] == pytest.approx(6.0 / 11.0)


@pytest.mark.parametrize("kind", ["adaptive", "fixed"])
def test_peers_are_tried_at_eight_settings_a_decade(kind):
    method: Any = SimpleNamespace(name="m", kind=kind)
    tried = bench_peers.settings(method)
    assert {chosen.method for chosen in tried} == {"m"}
    made = [chosen.rtol if kind == "adaptive" else chosen.step for chosen in tried]
    assert made == sorted(made, reverse=True)
    if kind == "adaptive":
        assert (made[0], made[8]) == pytest.approx((3e-4, 3e-6))
    else:
        assert (made[0], made[8], made[-1]) == pytest.approx((0.02, 2e-3, 2e-9))


def test_a_right_hand_side_takes_the_processor_time_that_passes(monkeypatch):
    clock = iter((7.5, 9.75))
    monkeypatch.setattr(bench_rhs, "process_time", lambda: next(clock))
    assert bench_rhs._processor_time(lambda: None) == 2.25


def test_verdicts_of_a_tree_are_counted_and_each_is_printed_with_its_sentence(capsys):
    found = [
        regression.Finding(f"c{k}", word, f"because {k}", None) for k, word in enumerate(("same", "slower", "same"))
    ]
    benchmark = SimpleNamespace(extra_info={})
    assert bench_timing.counts_of(benchmark, found, share=0.1) == {"same": 2, "slower": 1}
    assert benchmark.extra_info == {"verdicts": {"same": 2, "slower": 1}, "share": 0.1}
    assert capsys.readouterr().out.splitlines() == ["same: because 0", "slower: because 1", "same: because 2"]


def test_the_coarsest_tolerance_that_reaches_the_error(monkeypatch):
    monkeypatch.setattr(bench_batch, "_batch", lambda starts, settings, lanes: settings.rtol)
    monkeypatch.setattr(bench_batch, "_ends", lambda rtol: rtol)
    monkeypatch.setattr(bench_batch, "farthest", lambda scene, one, other: [one.position * bench_batch.ERROR * 3e6])
    assert bench_batch._coarsest_of_ours(None, 0.0, False).rtol == 1e-7  # type: ignore[arg-type]


def test_the_first_call_of_a_growth_compiles_and_is_left_out(monkeypatch):
    clock = iter(np.cumsum(np.append(0.0, np.random.default_rng(1).uniform(0.1, 2.0, 200))).tolist())
    seen: list[float] = []

    def now() -> float:
        seen.append(next(clock))
        return seen[-1]

    system = SimpleNamespace(initial_state=lambda: np.zeros(2))
    monkeypatch.setattr(bench_growth, "time", SimpleNamespace(process_time=now))
    asked: dict[str, Any] = {}
    monkeypatch.setattr(bench_growth, "compiled", lambda *given: asked.update(compiled=given) or ("plan", system, None))
    for name in ("simulate", "start_run", "run_legs"):
        monkeypatch.setattr(bench_growth, name, lambda *given, name=name: asked.update({name: given}))
    found = bench_growth.times("pendulum_chain", 3, Settings())
    scene = scenes.make("pendulum_chain", links=3)
    assert (asked["compiled"], asked["simulate"]) == ((scene, Settings(), None), (scene, Settings()))
    assert asked["start_run"][:2] == asked["run_legs"][:2] == (system, "plan")
    spans = np.diff(seen)[::2]
    assert len(spans) == 2 * (1 + bench_growth.TURNS)
    assert found == pytest.approx((median(spans[2::2]), median(spans[3::2])))


def tree(name: str, reached: bool, asked: list[Any]) -> Any:
    rungs = [{"status": "success", "error": 1e-9 if reached else 1.0, "settings": {"step": name}}]
    return SimpleNamespace(climb=lambda **case: rungs, time=lambda **case: asked.append((name, case)) or Sample(1.0))


def test_each_tree_is_timed_at_its_own_setting_and_the_one_that_fails_is_named(monkeypatch):
    asked: list[Any] = []
    monkeypatch.setattr(regression, "compare", lambda one, other, seed: (one(), other()) and _Timing)
    monkeypatch.setattr(regression, "_sentence", lambda *given: "")
    regression.examine(tree("a", True, asked), tree("b", True, asked), regression.CASES[0])
    assert [(name, case["settings"]) for name, case in asked] == [("a", {"step": "a"}), ("b", {"step": "b"})]
    for ours, theirs, name in ((False, True, "baseline"), (True, False, "current tree")):
        found = regression.examine(tree("a", ours, asked), tree("b", theirs, asked), regression.CASES[0])
        assert found.sentence.startswith(f"no setting of the {name} reaches")


_Timing: Any = SimpleNamespace(pace="same")


@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_tree_that_loads_other_packages_is_refused(monkeypatch, tmp_path, elsewhere):
    (tmp_path / "mbs_ref").mkdir()
    (tmp_path / "mbs_ref" / "__init__.py").write_text("")
    loaded = tmp_path / "other" if elsewhere else tmp_path
    child = SimpleNamespace(stdout=io.StringIO(json.dumps({"tree": str(loaded)}) + "\n"))
    monkeypatch.setattr(regression.subprocess, "Popen", lambda *given, **more: child)
    if not elsewhere:
        assert regression.Tree(tmp_path).folder == tmp_path.resolve()
        return
    with pytest.raises(RuntimeError, match="were loaded instead of"):
        regression.Tree(tmp_path)


def test_a_worker_answers_what_it_is_asked(monkeypatch):
    said: list[Any] = []
    lines = [json.dumps({"do": name, "x": k}) for k, name in enumerate(("climb", "time", "rate"))]
    monkeypatch.setattr(worker, "_say", lambda answers, answer: said.append(answer))
    monkeypatch.setattr(worker, "os", SimpleNamespace(fdopen=lambda *given: None, dup=lambda n: n, dup2=lambda *n: None,
                                                      path=worker.os.path))  # fmt: skip
    monkeypatch.setattr(worker.sys, "stdin", io.StringIO("\n".join(lines) + "\n"))
    for name, answer in (("climb", "a"), ("timed", "b"), ("rate", "c")):
        monkeypatch.setattr(worker, name, lambda x, answer=answer: f"{answer}{x}")
    worker.main()
    assert said[1:] == ["a0", "b1", "c2"]


def test_a_rate_is_the_time_of_one_body_of_one_right_hand_side(monkeypatch):
    """A clock that shows 3 us for each of four bodies' right-hand sides, and 1 s more for nothing else."""
    spent = [0.0]

    def run(count: int) -> None:
        spent[0] += 12e-6 * count

    monkeypatch.setattr(worker, "_rated", {("chain", "{}"): (run, 4)})
    monkeypatch.setattr(worker, "time", SimpleNamespace(process_time=lambda: spent[0]))
    assert worker.rate("chain", {}, 0.5) == {"ns_per_body": pytest.approx(3000.0)}


def test_a_rung_has_the_largest_error_that_it_may_have_and_none_follows_a_slow_one(monkeypatch):
    """Errors with the truth's uncertainty, in the order of the ladder; the first rung above a second is the last."""
    loops = (0.2, 0.9, 1.1, 2.0)
    statuses = ("success", "lost", "success", "success")
    errors = [None if k == 1 else Error(10.0**-k, "exact", 0.3 * 10.0**-k, None) for k in range(4)]
    made = [Record("pendulum", {}, "mbs_ref", "rk4", {"step": loop}, status, times={"loop_s": loop}, error=error)
            for loop, status, error in zip(loops, statuses, errors, strict=True)]  # fmt: skip
    given, asked = iter(made), []
    monkeypatch.setattr(ladder, "rungs", lambda method, scene: [r.settings for r in made])
    monkeypatch.setattr(one_run, "evaluate", lambda *words: asked.append(words[1:3]) or next(given))
    found = worker.climb("pendulum", {"length": 2.0}, "mbs_ref", "rk4")
    bounds = [1.3, None, pytest.approx(1.3e-2)]
    assert found == [{"settings": r.settings, "status": r.status, "error": error, "loop_s": r.times["loop_s"]}
                     for r, error in zip(made[:3], bounds, strict=True)]  # fmt: skip
    assert asked == [("mbs_ref", r.settings) for r in made[:3]]


def test_a_timed_run_is_its_loop_and_the_share_of_a_processor_in_the_call(monkeypatch):
    clocks = {"perf_counter": iter((10.0, 14.0)), "process_time": iter((1.0, 2.0))}
    monkeypatch.setattr(worker, "time", SimpleNamespace(**{name: of.__next__ for name, of in clocks.items()}))
    seen: list[Any] = []
    run = lambda *given: seen.append(given) or SimpleNamespace(timing=Timing(build_s=9.0, loop_s=0.5))  # noqa: E731
    monkeypatch.setattr(engines, "get", lambda name: SimpleNamespace(run=run))
    found = worker.timed("pendulum", {"length": 2.0}, "exudyn", {"method": "rk4", "step": 0.25})
    assert found == {"loop_s": 0.5, "cpu_share": 0.25}
    ((scene, settings, times),) = seen
    assert (scene.parameters["length"], settings.step, times[-1]) == (2.0, 0.25, scene.duration)


def test_a_tree_is_asked_and_answers_line_by_line(tmp_path):
    """What each method of a tree asks is what its worker knows; a worker that ends is named with its exit code."""
    answers = ({"rungs": 1}, {"loop_s": 0.5, "cpu_share": 1.0}, {"ns_per_body": 7.0})
    said, replies = io.StringIO(), io.StringIO("".join(json.dumps(one) + "\n" for one in answers))
    ended: list[str] = []
    asked = regression.Tree.__new__(regression.Tree)
    asked.folder = tmp_path
    asked._child = SimpleNamespace(  # type: ignore[assignment]
        stdin=said,
        stdout=replies,
        wait=lambda: 3,
        kill=lambda: ended.append("kill"),
        communicate=lambda: ended.append(""),
    )
    with asked:
        assert (asked.climb(scene="a"), asked.time(scene="b")) == (answers[0], Sample(0.5, 1.0))
        assert asked.rate(scene="c", seconds=0.1) == 7.0
        with pytest.raises(RuntimeError, match=r"does not run: exit code 3"):
            asked.climb(scene="d")
    lines = [json.loads(line) for line in said.getvalue().splitlines()]
    words = zip(("climb", "time", "rate", "climb"), "abcd", strict=True)
    assert [(line["do"], line["scene"]) for line in lines] == list(words)
    assert ended == ["kill", ""]


def test_a_copy_of_a_tree_is_slowed_at_the_end_of_its_kernel(monkeypatch, tmp_path):
    """Packages are copied without compiled files; a slowed kernel has so many more turns, whatever it had before."""
    monkeypatch.setattr(slowed, "PACKAGES", ("benchmarks/trees", "mbs_ref/kernels/planar"))
    copied = slowed.copy_tree(tmp_path / "copy")
    for package in slowed.PACKAGES:
        held, own = ({file.relative_to(root): file.read_bytes() for file in (root / package).rglob("*")
                      if file.is_file() and (root is copied or "__pycache__" not in file.parts)}
                     for root in (copied, slowed.HERE))  # fmt: skip
        assert held == own
    kernel = (slowed.HERE / slowed.KERNEL).read_text()
    for turns in (50, 7):
        slowed.slow_down(copied, turns)
        changed = (copied / slowed.KERNEL).read_text()
        made, own = ({node.name: node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)}
                     for text in (changed, kernel))  # fmt: skip
        assert [name for name in own if ast.dump(made[name]) != ast.dump(own[name])] == [slowed.FUNCTION]
        more = made[slowed.FUNCTION].body[len(own[slowed.FUNCTION].body) :]
        assert ast.unparse(made[slowed.FUNCTION].body[: -len(more)]) == ast.unparse(own[slowed.FUNCTION].body)
        assert f"in range({turns}):" in ast.unparse(more)


def test_a_comparison_is_told_with_its_interval_and_what_disturbed_it(monkeypatch):
    case = replace(regression.CASES[0], error=1e-5)
    sentences = {disturbed: regression._sentence(Comparison(Pace.SLOWER, 1.2345, 1.1, 1.4, 9, disturbed), case)
            for disturbed in (0.0, 0.1, 0.25)}  # fmt: skip
    sentence = "1.234 times the baseline's loop time [1.100, 1.400] to 1e-05 of the scene, 9 blocks"
    assert sentences == {0.0: sentence, 0.1: sentence, 0.25: f"{sentence}; 25% of the runs shared the machine"}
    afresh: list[Any] = []
    monkeypatch.setattr(regression, "Tree", nullcontext)
    monkeypatch.setattr(regression, "examine", lambda *given: afresh.append(given) or SimpleNamespace(changed=True))
    monkeypatch.setattr(regression, "confirmed", lambda finding, again: again())
    steps: list[Any] = []
    list(regression.regressions(Path("a"), Path("b"), [case], lambda *given: steps.append(given), seed=4))
    assert [given[:3] for given in afresh] == [(Path("a"), Path("b"), case)] * 2
    assert (afresh[0][3:], steps) == ((4,), [(0, 1, case.name)])
