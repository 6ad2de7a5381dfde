"""The timing verdict on known clocks, change points, and the history's files."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from benchmarks.history import Entry, change_points, from_benchmarks, series
from benchmarks.trees.regression import Finding, cheapest, confirmed, overall
from cross_checks.prices.timing import Pace, Sample, compare, with_loops
from cross_checks.records.lines import Busy, append, exclusive, read
from cross_checks.records.record import Record


def clock(seconds: float, seed: int, noise: float = 0.02):
    """A machine whose noise only ever adds time, as real ones do."""
    random = np.random.default_rng(seed)
    return lambda: Sample(seconds * (1.0 + random.exponential(noise)))


@pytest.mark.parametrize(
    ("factor", "pace"), [(1.0, Pace.SAME), (1.1, Pace.SLOWER), (1.15, Pace.SLOWER), (0.85, Pace.FASTER)]
)
def test_known_clocks(factor, pace):
    for seed in range(10):
        assert compare(clock(1.0, seed), clock(factor, 100 + seed), seed).pace is pace


def said(*verdicts: str):
    """Findings of one pair of processes after another."""
    return iter([Finding("case", verdict, f"pair {i}", 1e-6) for i, verdict in enumerate(verdicts)])


@pytest.mark.parametrize(
    ("verdicts", "expected"),
    [
        (("slower", "slower"), "slower"),
        (("faster", "same", "same"), "same"),
        (("faster", "same", "faster"), "faster"),
        (("slower", "same", "faster"), "inconclusive"),
    ],
)
def test_a_change_is_believed_when_two_pairs_of_processes_see_it(verdicts, expected):
    pairs = said(*verdicts)
    found = confirmed(next(pairs), lambda: next(pairs))
    assert found.verdict == expected
    assert next(pairs, None) is None


def test_a_machine_too_noisy_is_inconclusive_and_flagged():
    random = np.random.default_rng(1)
    wild = lambda: Sample(math.exp(random.normal(0.0, 2.0)), 0.5)  # noqa: E731
    found = compare(wild, wild)
    assert found.pace is Pace.INCONCLUSIVE
    assert found.disturbed == 1.0


def test_change_points():
    random = np.random.default_rng(3)
    steady = np.exp(random.normal(0.0, 0.02, 40))
    assert change_points(list(steady)) == []
    jumped = steady * np.where(np.arange(40) < 25, 1.0, 1.15)
    (place,) = change_points(list(jumped))
    assert abs(place - 25) <= 1


def entry(k: int) -> Entry:
    return Entry(f"job{k}", f"2026-01-{k + 1:02d}T00:00:00+00:00", "abc", "box", "ratio chain", 1.0 + k, "1")


def test_series_follow_the_lines_and_skip_what_is_corrupt(tmp_path):
    file = tmp_path / "history.jsonl"
    append(file, [entry(0)])
    with file.open("ab") as torn:
        torn.write(b'{"job": "cut off')
    append(file, [entry(1)])
    entries, problems = read(file, Entry)
    assert [e.value for e in series(entries)["ratio chain"]] == [1.0, 2.0]
    assert len(problems) == 1
    assert "history.jsonl:2" in problems[0]
    assert series(entries, "nothing") == series(entries, "2026") == {}
    assert series(entries, "chain") == series(entries)


def test_benchmarks_become_entries():
    data = {"benchmarks": [{"name": "chain", "stats": {"min": 2.0}, "extra_info": {"error": 1e-7, "loop_s": 0.5}}]}
    (found,) = from_benchmarks(data, "job", "now", "abc", "box")
    assert (found.value, found.error) == (0.5, 1e-7)


def test_a_benchmark_that_compares_two_loops_counts_by_its_own_time():
    data = {"benchmarks": [{"name": "track", "stats": {"min": 2.0}, "extra_info": {"loop_s": [0.5, 0.6]}}]}
    (found,) = from_benchmarks(data, "job", "now", "abc", "box")
    assert (found.value, found.error) == (2.0, None)


def test_the_worst_verdict_counts():
    def of(*words):
        return overall([Finding("case", word, "", 1e-6) for word in words])

    assert of("same", "slower", "not measured") == "slower"
    assert of("same", "not measured", "inconclusive") == "not measured"
    assert of("same", "same") == "same"
    assert of() == "not measured"


def test_the_coarsest_rung_within_the_error_is_chosen():
    runs = [("success", 1e-3, 0.1), ("diverged", None, 0.05), ("success", 1e-7, 0.01), ("success", 1e-9, 0.001)]
    rungs = [{"status": s, "error": e, "settings": {"step": h}} for s, e, h in runs]
    assert cheapest(rungs, 1e-6) == {"step": 0.01}
    assert cheapest(rungs, 1e-12) is None


@pytest.mark.parametrize("count", [4, 5])
def test_loop_times_of_a_record(count):
    chance = random.Random(count)
    loops = [chance.uniform(0.1, 2.0) for _ in range(count)]
    run = with_loops(Record("pendulum", {}, "quick", "rk4", {}, "success", times={"build_s": 0.7}), loops, "busy")
    ordered = sorted(loops)
    middle = (ordered[(count - 1) // 2] + ordered[count // 2]) / 2.0
    assert run.times == {
        "build_s": 0.7, "loop_s": ordered[0], "loop_median_s": middle, "loop_most_s": ordered[-1], "loop_runs": count
    }  # fmt: skip
    assert run.notes == ("busy",)


def test_two_sweeps_do_not_write_one_file(tmp_path):
    with exclusive(tmp_path / "r.jsonl"), pytest.raises(Busy, match="another process"), exclusive(tmp_path / "r.jsonl"):
        pass
