"""Loop times of what is ranked: when they are enough, and how a busy machine's are kept apart."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cross_checks.judge.ladder import grid
from cross_checks.judge.one_run import evaluate
from cross_checks.judge.runs import Runs
from cross_checks.prices import timing as loop_times
from cross_checks.prices.timing import is_enough, machine, stored_times, timed_all
from cross_checks.records.record import Record, is_busy, is_timed
from cross_checks.records.store import Run, Store
from mbs_ref import scenes
from mbs_ref.settings import Settings
from reports.facts.report_data import contenders
from tests.reports.page.synthetic_report import report_data

SCENE = scenes.make("pendulum")


@pytest.fixture(scope="module")
def record() -> Record:
    return evaluate(SCENE, "mbs_ref", Settings(method="rk4", step=SCENE.duration / 40), grid(SCENE))


@pytest.mark.parametrize(
    ("loops", "enough"),
    [([1.0, 1.0], False), ([1.0, 1.01, 1.02], True), ([1.0, 1.2, 1.4], False), ([1.0, 2.0, 3.0, 4.0, 5.0], True)],
)
def test_runs_repeat_until_their_interval_is_narrow_or_the_bound_is_met(loops, enough):
    assert is_enough([1e-3 * loop for loop in loops]) is enough


@pytest.mark.parametrize(("loop", "runs", "counted"), [(0.1, 4, 3), (0.3, 3, 3), (1.5, 1, 1)])
def test_a_short_run_warms_up_and_a_longer_one_counts(monkeypatch, loop, runs, counted):
    made: list[float] = []
    monkeypatch.setattr(loop_times, "sample", lambda *run: made.append(loop) or loop_times.Sample(loop))
    loops, share = loop_times.time_loops(SCENE, "mbs_ref", Settings())
    assert (len(made), loops, share) == (runs, [loop] * counted, 1.0)


def test_times_are_measured_once_and_kept(record, monkeypatch):
    with Store() as store:
        first = timed_all(store, [record], lambda done, total, what: None)[id(record)]
        assert is_timed(first)
        monkeypatch.setattr(loop_times, "time_loops", None)  # would not travel to another process
        again = timed_all(store, [record], lambda done, total, what: None)[id(record)]
        assert again.times == first.times


@pytest.mark.parametrize(("loop", "share", "held"), [(0.5, 0.95, [0.5]), (0.5, 0.5, []), (0.1, 1.0, [])])
def test_the_time_of_a_long_search_run_with_a_processor_to_itself_counts(record, loop, share, held):
    settings = Settings(**record.settings)
    made = Run(replace(record, times=record.times | {"loop_s": loop, "cpu_share": share}), None, "box")
    with Store() as store:
        Runs(store, call=lambda *given: made).run(SCENE, "mbs_ref", settings)
        assert store.timings(loop_times._key(SCENE, record), "box") == held


def test_a_busy_machines_time_is_marked_and_gives_way_to_a_quiet_one(record):
    with Store() as store:
        store.keep_timings(loop_times._key(SCENE, record), machine() + loop_times.SHARED, [3.0, 3.0, 3.0])
        busy = stored_times(store, SCENE, record)
        assert busy is not None
        assert is_busy(busy)
        store.keep_timings(loop_times._key(SCENE, record), machine(), [1.0, 1.0, 1.1])
        quiet = stored_times(store, SCENE, record)
        assert quiet is not None
        assert not is_busy(quiet)
        assert (quiet.times["loop_s"], quiet.times["loop_most_s"]) == (1.0, 1.1)


def test_only_what_may_win_is_timed():
    data = report_data()
    ranked = contenders(data)
    assert 0 < len(ranked) < len(data.records) / 2
    ours = {r.method for r in ranked if r.engine == "mbs_ref"}
    assert ours == {"rk4"}, "the others are dearer by more than NEAR at every target"
