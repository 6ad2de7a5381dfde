"""Figures of histories, calibration and slowed trees, recomputed from made-up data."""

from __future__ import annotations

import random
from contextlib import nullcontext
from itertools import chain
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks import calibration, history, method_table
from benchmarks.calibration import Trial, table
from benchmarks.history import Entry, _strongest, from_benchmarks, from_records, new_levels, series
from benchmarks.suites import bench_rhs, bench_timing
from benchmarks.trees import regression, slowed
from benchmarks.trees.regression import CASES
from cross_checks.isolation.parent import ONE_THREAD
from cross_checks.prices.timing import Sample
from cross_checks.records import lines
from cross_checks.records.record import Error, Record

JOB = ("job", "2026-01-01", "abc", "box")


def entries(values: list[float]) -> list[Entry]:
    return [Entry(f"job{k}", f"2026-{k:04d}", "abc", "box", "chain", value, "s") for k, value in enumerate(values)]


def test_a_series_is_in_the_order_of_time(tmp_path):
    values = [3.0, 1.0, 2.0]
    lines.append(tmp_path / "h.jsonl", entries(values)[::-1])
    stored, _ = lines.read(tmp_path / "h.jsonl", Entry)
    assert [entry.value for entry in series(stored)["chain"]] == values


@pytest.mark.parametrize(("factor", "is_new"), [(1.03, False), (1.12, True), (0.9, True)])
def test_the_last_change_of_level_is_the_new_one(factor, is_new):
    noise = np.exp(np.random.default_rng(2).normal(0.0, 0.004, 21))
    made = entries((noise * np.repeat([1.0, 1.5, 1.5 * factor], [8, 8, 5])).tolist())
    assert new_levels({"chain": made}) == ({"chain": made[16]} if is_new else {})


def test_the_fastest_round_of_a_benchmark_counts():
    data = {"benchmarks": [{"name": "a", "stats": {"max": 9.0, "mean": 4.0, "min": 2.0}, "extra_info": {}}]}
    assert from_benchmarks(data, *JOB)[0].value == 2.0


def test_an_engines_cheapest_run_is_stored_with_all_that_its_error_may_be():
    runs = [Record("pendulum", {}, "quick", "rk4", {"step": step}, "success", times={"loop_s": loop},
                   error=Error(error, "exact", 1e-9, None))
            for step, loop, error in ((0.1, 0.3, 9e-4), (0.01, 0.5, 2e-7), (0.02, 0.4, 5e-7))]  # fmt: skip
    (entry,) = from_records(runs, "pendulum", 1e-6, *JOB)
    assert (entry.value, entry.error) == (0.4, pytest.approx(5.01e-7))


def test_percentiles_of_the_overestimate_are_those_of_the_decided_runs():
    """Estimates of 1 to 101 errors: the hundredth part of them is below 2."""
    rng = np.random.default_rng(5)
    trials = [Trial(0, "a", "m", "", "success", k * 0.5, 0.5, 1e-9, 2.0) for k in rng.permutation(np.arange(1, 102))]
    row = table(trials)[0]
    assert [row[f"overestimate_{name}"] for name in ("1", "median", "90")] == pytest.approx([2.0, 51.0, 91.0])
    undecided = Trial(0, "a", "m", "", "success", 1.0, 2.0, 5.0, 2.0)
    below = Trial(0, "a", "m", "", "success", 1.0, 2.0, 1e-9, 2.0)
    assert table([undecided] * 3 + [below] + trials[:3])[0]["share_below"] == pytest.approx(1.0 / 4.0, abs=0.1)


def test_the_excess_is_what_the_second_tree_takes_longer():
    def tree(seconds: float) -> Any:
        rungs = [{"status": "success", "error": 1e-9, "settings": {"step": 0.1}}]
        return SimpleNamespace(climb=lambda **_: rungs, time=lambda **_: Sample(seconds))

    assert slowed.excess(tree(2.0), tree(2.5), CASES[0]) == pytest.approx(0.25)


def test_a_tree_is_slowed_until_it_takes_the_requested_share(monkeypatch, tmp_path):
    """A turn takes 0.2 % of the case: 15 % are 75 turns, to a fiftieth of the time."""
    turns: list[int] = []
    monkeypatch.setattr(slowed, "slow_down", lambda folder, count: turns.append(count))
    monkeypatch.setattr(slowed, "Tree", lambda folder: nullcontext())
    monkeypatch.setattr(slowed, "excess", lambda before, after, case: 0.002 * turns[-1])
    found, share = slowed.calibrate(tmp_path, CASES[0], 0.15)
    assert (found, share) == (75, pytest.approx(0.15))
    assert turns == [slowed.FIRST_GUESS, 75]


def test_the_cost_of_a_call_is_its_processor_time(monkeypatch):
    clock = iter((3.0, 5.5))
    monkeypatch.setattr(method_table.time, "process_time", lambda: next(clock))
    monkeypatch.setattr(method_table, "_run", lambda *given: given)
    assert method_table._called(None, "rk4", 1e-3) == (2.5, (None, "rk4", 1e-3))  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(4))
def test_a_choice_is_compared_with_the_cheapest_that_errs_no_more(monkeypatch, seed):
    """Costs and errors have no pattern; errors below roundoff are alike, and calls that fail do not count."""
    chance, known = random.Random(seed), {}

    def drawn(key: tuple[str, float]) -> tuple[float, float, bool]:
        return known.setdefault(key, (chance.uniform(1, 9), 10 ** chance.uniform(-15, -3), chance.random() < 0.7))

    def run(scene: Any, method: str, rtol: float) -> Any:
        return SimpleNamespace(
            ok=rtol == method_table.TIGHT or drawn((method, rtol))[2], key=(method, rtol), method=method
        )

    monkeypatch.setattr(method_table, "LOST", 1.0)
    monkeypatch.setattr(method_table, "FAR", np.inf)
    monkeypatch.setattr(method_table, "_run", run)
    monkeypatch.setattr(method_table, "_called", lambda *given: (drawn(given[1:])[0], run(*given)))
    monkeypatch.setattr(method_table, "_error", lambda scene, path, tight: drawn(path.key)[1])
    monkeypatch.setattr(method_table, "_in_turns", lambda scene, *keys: [drawn(key)[0] for key in keys])
    rows = {row.wanted: row for row in method_table.rows("pendulum")}
    fixed = [(key, *of) for key, of in known.items()
             if key[0] in method_table.METHODS and key[1] in method_table.TRIED and of[2]]  # fmt: skip
    for wanted in method_table.ASKED:
        cost, error, _ = known["auto", wanted]
        fitting = [(c, key) for key, c, e, _ in fixed if e <= max(error, 1e-12)]
        assert (wanted in rows) == bool(fitting)
        if fitting:
            best, (method, rtol) = min(fitting)
            assert rows[wanted] == method_table.Row(
                "pendulum", wanted, "auto", error, f"{method} {rtol:g}", cost, cost / best
            )


def test_the_cheapest_of_the_few_by_their_turns_is_the_best(monkeypatch):
    """A first call takes 1 s at rtol 1e-3 and 0.1 s more each decade; in turns the third cheapest takes the least."""
    turns = {1e-3: 5.0, 1e-4: 4.0, 1e-5: 3.0, 1e-6: 3.5, 1e-7: 0.1}

    def called(scene: Any, method: str, rtol: float) -> tuple[float, Any]:
        return 0.7 - 0.1 * np.log10(rtol), SimpleNamespace(ok=method in ("auto", "dop853"), method=method)

    asked: list[Any] = []
    monkeypatch.setattr(method_table, "_run", lambda *given: called(*given)[1])
    monkeypatch.setattr(method_table, "_called", called)
    monkeypatch.setattr(method_table, "_error", lambda *given: 0.0)
    monkeypatch.setattr(
        method_table, "_in_turns",
        lambda scene, own, *keys: asked.append(keys) or [6.0, *(turns[round(rtol, 12)] for _, rtol in keys)],
    )  # fmt: skip
    for row in method_table.rows("pendulum"):
        assert (row.best, row.ratio) == ("dop853 1e-05", 2.0)
    assert [[f"{rtol:g}" for _, rtol in keys] for keys in asked] == [["0.001", "0.0001", "1e-05", "1e-06"]] * 4


def test_a_method_far_dearer_than_the_chosen_one_ends_at_that_tolerance(monkeypatch):
    """LSODAR takes ten times as long a decade; the chosen runs take 1 s, and 4 s is far from that."""
    tried: list[float] = []

    def called(scene: Any, method: str, rtol: float) -> tuple[float, Any]:
        tried.extend([rtol] if method == "lsodar" else [])
        return 1e-3 / rtol if method == "lsodar" else 1.0, SimpleNamespace(ok=True, method=method)

    monkeypatch.setattr(method_table, "_run", lambda *given: called(*given)[1])
    monkeypatch.setattr(method_table, "_called", called)
    monkeypatch.setattr(method_table, "_error", lambda *given: 0.0)
    monkeypatch.setattr(method_table, "_in_turns", lambda scene, *keys: [1.0] * len(keys))
    assert len(list(method_table.rows("pendulum"))) == len(method_table.ASKED)
    assert [f"{rtol:g}" for rtol in tried] == ["0.001", "0.0001"]


@pytest.mark.parametrize(("first", "calls"), [(0.9, 6), (1.1, 1)])
def test_slow_calls_are_timed_once_and_quick_ones_in_further_turns(monkeypatch, first, calls):
    """Two choices whose first calls take 0.9 s or 1.1 s each; 2 s is slow. The least of the later calls counts."""
    made: dict[str, list[float]] = {"a": [], "b": []}

    def called(scene: Any, method: str, rtol: float) -> tuple[float, None]:
        made[method].append(first + 0.01 * len(made[method]) * (-1) ** len(made[method]))
        return made[method][-1], None

    monkeypatch.setattr(method_table, "_called", called)
    found = method_table._in_turns(None, ("a", 1.0), ("b", 1.0))  # type: ignore[arg-type]
    assert {name: len(own) for name, own in made.items()} == {"a": calls, "b": calls}
    assert found == [min(own[1:] or own) for own in made.values()]


def test_right_hand_sides_of_two_trees_are_compared_pair_by_pair(monkeypatch):
    """The second tree takes thrice the first's time of the same round; rounds differ ten thousandfold."""
    rounds = 10 ** np.random.default_rng(3).uniform(-2, 2, 15)
    asked: list[Any] = []

    def interleaved(runs: list[Any], count: int) -> list[Any]:
        asked.append(([run() for run in runs], count))
        return [rounds, 3.0 * rounds]

    monkeypatch.setattr(regression, "interleaved", interleaved)
    tree: Any = SimpleNamespace(rate=lambda **given: given)
    found = regression.rate_of(tree, tree, "andrews", {})
    assert asked == [([{"scene": "andrews", "parameters": {}, "seconds": regression.SECONDS}] * 2, 15)]
    assert found.ratio == pytest.approx(3.0)
    assert (found.old_ns_per_body, found.new_ns_per_body) == pytest.approx((rounds.min(), 3.0 * rounds.min()))


def test_the_cost_of_an_estimate_counts_over_the_loop(monkeypatch):
    run = SimpleNamespace(status="success", estimate=SimpleNamespace(value=3e-7, cost_s=7.0),
                          timing=SimpleNamespace(build_s=0.3, first_call_s=11.0, loop_s=2.0))  # fmt: skip
    asked: list[Any] = []
    monkeypatch.setattr(calibration, "simulate", lambda *given: asked.append(given[1]) or run)
    monkeypatch.setattr(calibration, "_truth", lambda scene, times: ("truth", 1e-9))
    monkeypatch.setattr(calibration, "_gap", lambda scene, path, truth: 5e-8)
    for seed in range(3, 9):  # of fixed and of adaptive methods
        found, chosen = calibration.trial(seed), asked
        assert (found.estimate, found.error, found.uncertainty, found.cost) == (3e-7, 5e-8, 1e-9, 3.5)
        word, value = ("step", chosen[-1].step) if chosen[-1].step else ("rtol", chosen[-1].rtol)
        assert (found.method, found.setting) == (chosen[-1].method, f"{word} {value:.3g}")
    assert len({one.step is None for one in asked}) == 2


def test_the_strongest_split_is_that_of_welchs_statistic():
    x = np.random.default_rng(4).normal(size=23) + np.repeat([0.0, 0.7], [6, 17])
    by_place = {k: abs(np.mean(x[:k]) - np.mean(x[k:])) / np.sqrt(np.var(x[:k]) / k + np.var(x[k:]) / (23 - k))
                for k in range(4, 20)}  # fmt: skip
    place, strength = _strongest(x)
    assert place == max(by_place, key=by_place.__getitem__)
    assert strength == pytest.approx(by_place[place], rel=1e-9)


def test_residuals_of_any_sign_count():
    class System:
        def __init__(self, scene: Any) -> None:
            self.mass_matrix, self.right_side = lambda: np.array([2.0, 2.0, 4.0]), lambda: np.array([0.25])

        def set_mode_time(self, t: float) -> None: ...

        def initial_state(self) -> np.ndarray:
            return np.zeros(6)

        def applied_forces(self, t: float, y: np.ndarray) -> np.ndarray:
            return np.array([[6.0, 0.0, 0.0]])  # m/s^2 of a mass of 2 kg that does not move

        def derivative(self, t: float, y: np.ndarray) -> np.ndarray:
            return np.array([0.0, 0.0, 0.0, 0.0, 0.5, 0.0])

        multipliers, jacobian = (lambda self, t, y: np.zeros(1)), (lambda self, t, y: np.array([[0.0, 1.0, 0.0]]))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bench_rhs, "PlanarSystem", System)
        assert bench_rhs.planar_residual(None) == 3.0  # type: ignore[arg-type]


def test_a_sample_is_the_wall_time_and_the_share_of_the_processor(monkeypatch):
    monkeypatch.setattr(bench_timing, "spin", lambda turns: None)
    for clock, times in (("perf_counter", (1.0, 3.0)), ("process_time", (5.0, 5.5))):
        monkeypatch.setattr(bench_timing.time, clock, iter(times).__next__)
    assert bench_timing.timed(7)() == Sample(2.0, 0.25)


def test_a_tree_is_timed_with_one_thread(monkeypatch):
    given = {}

    def begun(words: Any, **more: Any) -> Any:
        given.update(more)
        raise OSError("begun")

    monkeypatch.setattr(regression.subprocess, "Popen", begun)
    with pytest.raises(OSError, match="begun"):
        regression.Tree(slowed.HERE)
    assert given["env"].items() >= ONE_THREAD.items()
    assert given["env"]["PYTHONPATH"] == str(given["cwd"]) == str(slowed.HERE)


def test_the_table_of_methods_ends_with_all_ratios(monkeypatch, capsys):
    """A line a row in the order of the scenes; without names every scene; the share counts ratios up to 1.3."""
    made = {name: [method_table.Row(name, 1e-6, "gauss", 2e-8, f"radau {ratio:g}", 0.5, ratio) for ratio in ratios]
            for name, ratios in (("a", (1.3, 2.0)), ("b", (0.5,)), ("c", (1.31,)))}  # fmt: skip
    monkeypatch.setattr(method_table, "rows", made.__getitem__)
    monkeypatch.setattr(method_table.scenes, "names", lambda: list(made))
    for names in ([], ["b", "a"]):
        method_table.main(names)
        rows = [row for name in names or made for row in made[name]]
        *listed, last = capsys.readouterr().out.splitlines()
        assert [line.split() for line in listed] == [
            [r.scene, "1e-06", "gauss", "error", "2.0e-08", "500.00", "ms", f"{r.ratio:.2f}", "of", *r.best.split()]
            for r in rows]  # fmt: skip
        ratios = [r.ratio for r in rows]
        share = sum(x <= 1.3 for x in ratios) / len(ratios)
        assert last == (f"{len(rows)} rows: median {np.median(ratios):.2f}, {share:.0%} at most 1.3, largest 2.00")


def test_an_error_of_a_choice_is_of_poses_and_infinite_where_a_run_fails(monkeypatch):
    sizes = np.array([[0.1, 0.3, 9.0, 9.0], [0.2, 0.1, 9.0, 9.0]])
    monkeypatch.setattr(method_table, "relative", lambda scene, path, tight: sizes)
    for ok, error in ((True, 0.3), (False, np.inf)):
        assert method_table._error(None, SimpleNamespace(ok=ok), None) == error  # type: ignore[arg-type]
    given: list[Any] = []
    monkeypatch.setattr(method_table, "simulate", lambda scene, settings: given.append(settings))
    method_table._run(None, "radau", 1e-7)  # type: ignore[arg-type]
    (settings,) = given
    assert (settings.method, settings.rtol, settings.estimate, settings.reactions) == ("radau", 1e-7, "off", False)


@pytest.mark.parametrize(("by_chance", "where"), [(5, [9]), (6, [])])
def test_a_split_counts_unless_more_than_a_hundredth_of_permutations_are_as_strong(monkeypatch, by_chance, where):
    """Of 500; one that is exactly as strong counts as such."""
    strengths = iter([2.0] * by_chance + [1.0] * (500 - by_chance))
    shuffled, found = SimpleNamespace(permutation=lambda x: x), chain([2.0], strengths)
    monkeypatch.setattr(history, "_strongest", lambda x: (4, next(found)) if len(x) == 8 else (0, 0.0))
    assert history._split(np.repeat([0.0, 1.0], 4), 5, shuffled) == where  # type: ignore[arg-type]


def test_levels_that_differ_by_less_than_a_twentieth_are_one(monkeypatch):
    for factor, where in ((1.049, []), (1.051, [4])):
        by_chance = iter([(4, 9.0)] + [(4, 1.0)] * 500 + [(0, 0.0)] * 2)
        monkeypatch.setattr(history, "_strongest", lambda x, values=by_chance: next(values))
        assert history.change_points([2.0] * 4 + [2.0 * factor] * 4) == where
