"""Tasks side by side: a slow one delays no other, some are added and dropped meanwhile, an exception ends them all."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from functools import partial

import pytest

from cross_checks.isolation.parent import Isolated, Lost, direct
from cross_checks.isolation.workers import LAST, Late, Over, Pool, each
from tests.cross_checks.isolation import troubles


def add(a: float, call) -> float:
    return call(troubles.add, a, 1.0)


def hang(call) -> None:
    call(troubles.hang)


def test_a_task_that_hangs_comes_late_and_its_second_try_after_the_others():
    ends = []
    with Pool[str, object](Isolated(troubles.PATIENCE), workers=1, brief=troubles.BRIEF) as pool:
        pool.add("hangs", hang)
        for number in range(3):
            pool.add(f"adds {number}", partial(add, number))
        for name, result in pool:
            ends.append((name, result))
            if isinstance(result, Late):
                pool.add("hangs again", hang, tries=LAST)
            if name == "adds 2":
                pool.drop(lambda name: name == "hangs again")
    assert [name for name, _ in ends] == ["hangs", "adds 0", "adds 1", "adds 2"]
    assert isinstance(ends[0][1], Late)
    assert [result for _, result in ends[1:]] == [1.0, 2.0, 3.0]


def test_a_second_try_has_the_whole_time_and_comes_last():
    ends = []
    with Pool[str, object](Isolated(troubles.PATIENCE), workers=1, brief=1.0) as pool:
        pool.add("begins", hang)
        pool.add("again", partial(_sleep, 2.0), tries=LAST)
        pool.add("dear", partial(add, 1.0), seconds=9.0)
        pool.add("cheap", partial(add, 2.0), seconds=1.0)
        ends = list(pool)
    assert [name for name, _ in ends] == ["begins", "cheap", "dear", "again"]
    assert ends[-1] == ("again", "slept")


def test_a_call_that_is_expected_to_last_too_long_is_not_begun():
    """A first try is late at once, a second one lost."""
    with Pool[str, object](Isolated(10.0), workers=1, brief=1.0) as pool:
        for seconds in (0.5, 5.0):
            pool.add(f"first {seconds}", partial(_expected, seconds))
        for seconds in (5.0, 50.0):
            pool.add(f"again {seconds}", partial(_expected, seconds), tries=LAST)
        ends = dict(pool)
    assert isinstance(late := ends.pop("first 5.0"), Late)
    assert "was not begun" in str(late)
    assert ends == {"first 0.5": "begun", "again 5.0": "begun", "again 50.0": "timeout"}


def test_once_the_time_is_over_no_call_is_begun_and_none_is_lost():
    """A call that was under way ends, and one that would take longer than what is left is not begun."""
    with Pool[str, object](Isolated(1e3), workers=1, time_left=0.5) as pool:
        pool.add("long", partial(_expected, 1e2), tries=LAST)
        pool.add("hangs", hang)
        for number in range(2):
            pool.add(f"adds {number}", partial(add, number), tries=LAST)
        ends = dict(pool)
    assert {name: type(end) for name, end in ends.items()} == dict.fromkeys(("long", "hangs", "adds 0", "adds 1"), Over)


def test_a_call_that_had_its_whole_time_is_lost_though_time_is_left():
    with Pool[str, object](Isolated(1.0), workers=1, time_left=1e3) as pool:
        pool.add("hangs", hang, tries=LAST)
        with pytest.raises(Lost, match="no answer within 1 s"):
            list(pool)


def test_each_try_has_a_longer_time():
    with Pool[str, object](Isolated(1e3), workers=1, brief=1.0) as pool:
        for tries in range(LAST + 1):
            pool.add(f"try {tries}", partial(_expected, 3.0 * 10.0 ** (tries - 1)), tries=tries)
            pool.add(f"long try {tries}", partial(_expected, 3.0 * 10.0**tries), tries=tries)
        ends = {name: isinstance(end, Late) for name, end in pool}
    assert ends == {"try 0": False, "long try 0": True, "try 1": False, "long try 1": True,
                    "try 2": False, "long try 2": False}  # fmt: skip


def _expected(seconds: float, call) -> str:
    try:
        call.expect(seconds)
    except Lost as lost:
        return lost.status
    return "begun"


def _sleep(seconds: float, call) -> str:
    call(time.sleep, seconds)
    return "slept"


def test_a_dropped_task_under_way_ends_and_its_worker_goes_on():
    """In the time of the test no hanging call could end by itself."""
    with Pool[str, object](Isolated(1e3), workers=2) as pool:
        pool.add("hangs", hang)
        pool.add("adds", partial(add, 1.0))
        results = iter(pool)
        assert next(results) == ("adds", 2.0)
        assert [name for name, _ in pool.running()] == ["hangs"]
        pool.drop(lambda name: name == "hangs")
        for number in range(4):
            pool.add(f"adds {number}", partial(add, number))
        assert sorted(result for _, result in results) == [1.0, 2.0, 3.0, 4.0]  # type: ignore[type-var]
    assert pool.running() == []


def test_exceptions_are_raised_where_the_results_are_received():
    before = threading.active_count()
    with Pool[str, object](Isolated(1e3)) as pool:
        pool.add("hangs", hang)
        pool.add("raises", lambda call: call(troubles.raise_value_error, "seven"))
        with pytest.raises(ValueError, match="seven"):
            list(pool)
    assert threading.active_count() == before


def test_without_processes_tasks_are_made_here_cheapest_first():
    seen = []
    with Pool[str, int](direct, tick=lambda running: seen.append(running)) as pool:
        pool.add("dear", lambda call: call(os.getpid), seconds=2.0)
        pool.add("cheap", lambda call: call(os.getpid), seconds=1.0)
        assert list(pool) == [("cheap", os.getpid()), ("dear", os.getpid())]
    assert len(seen) == 2


def test_each_gives_every_task_its_result():
    assert sorted(each([1.0, 2.0], lambda call, a: call(troubles.add, a, a))) == [(1.0, 2.0), (2.0, 4.0)]


def test_a_generator_that_nobody_closes_does_not_keep_the_program_alive():
    program = """
import time
from cross_checks.isolation.workers import each
held = each([0.0, 3600.0], lambda call, seconds: call(time.sleep, seconds))
print(next(held)[0])
raise SystemExit(3)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=troubles.PATIENCE, check=False)
    assert (done.returncode, done.stdout) == (3, b"0.0\n")
