"""A call that hangs, crashes or eats memory costs itself, and the next call works."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numba
import pytest

from cross_checks.isolation import messages
from cross_checks.isolation.messages import compiling_reported
from cross_checks.isolation.parent import Cancelled, Isolated, Lost
from tests.cross_checks.isolation import troubles


@pytest.fixture(scope="module")
def isolated():
    with Isolated(timeout=troubles.PATIENCE, memory=300 * 2**20) as child:
        yield child


@pytest.fixture(params=["in the child", "in a copy of it"])
def call(request, isolated):
    isolated.timeout = troubles.PATIENCE
    return isolated if request.param == "in the child" else isolated.apart


def test_results_and_exceptions_come_back(call):
    assert call(troubles.add, 1.0, 2.0) == 3.0
    with pytest.raises(ValueError, match="seven"):
        call(troubles.raise_value_error, "seven")


@pytest.mark.parametrize(
    ("trouble", "status", "words"),
    [
        (troubles.hang, "timeout", "no answer within 2 s"),
        (troubles.segfault, "crashed", "SIGSEGV"),
        (troubles.leave, "crashed", "exit code 7"),
        (troubles.eat_memory, "out-of-memory", "MiB"),
    ],
)
def test_what_is_lost_is_named_and_the_next_call_works(isolated, call, trouble, status, words):
    isolated.timeout = troubles.patience(status)
    with pytest.raises(Lost, match=words) as lost:
        call(trouble)
    assert lost.value.status == status
    isolated.timeout = troubles.PATIENCE
    assert call(troubles.add, 1.0, 1.0) == 2.0


@pytest.mark.slow
def test_time_spent_compiling_is_not_the_calls(isolated, call):
    isolated.timeout = troubles.BRIEF
    assert call(troubles.compile_slowly, troubles.BRIEF + 1.0) == "compiled"
    with pytest.raises(Lost, match="no answer within 2 s"):
        call(troubles.compile_and_hang)


@pytest.mark.slow
def test_who_waits_for_a_compiler_is_waited_for(isolated):
    isolated.timeout = troubles.PATIENCE
    assert isolated(troubles.start_inner) == 2.0
    isolated.timeout = troubles.BRIEF
    assert isolated(troubles.wait_for_a_compiler, 3.0 * troubles.BRIEF) == "compiled"
    with pytest.raises(Lost, match="no answer within 2 s"):
        isolated(troubles.lose_a_compiler)


def test_compiling_has_its_own_limit(monkeypatch, isolated, call):
    monkeypatch.setattr(messages, "COMPILATION", 0.5)
    with pytest.raises(Lost, match=r"compiled for more than 0\.5 s"):
        call(troubles.compile_slowly, 60.0)
    monkeypatch.undo()
    assert call(troubles.add, 1.0, 1.0) == 2.0


def test_a_real_compilation_is_told_once_whatever_it_calls():
    inner = numba.njit(lambda x: x + 1.0)
    outer = numba.njit(lambda x: 2.0 * inner(x))
    told = []
    with compiling_reported(lambda: told.append("begins"), lambda: told.append("ends")):
        assert outer(1.0) == 4.0
        assert outer(2.0) == 6.0
    assert told == ["begins", "ends"]


@pytest.mark.parametrize("kind", [Isolated.__call__, Isolated.apart])
def test_a_cancelled_call_ends_and_no_other_starts(kind):
    with Isolated(timeout=60.0) as isolated:
        threading.Timer(0.3, isolated.cancel).start()
        for _ in range(2):
            with pytest.raises(Cancelled):
                kind(isolated, troubles.hang)


def test_a_lost_copy_leaves_the_child_and_all_it_has_loaded(isolated):
    isolated.timeout = troubles.PATIENCE
    isolated(troubles.remember, 7.0)
    before = isolated(os.getpid)
    for trouble, status in ((troubles.segfault, "crashed"), (troubles.hang, "timeout")):
        isolated.timeout = troubles.patience(status)
        with pytest.raises(Lost) as lost:
            isolated.apart(trouble)
        assert lost.value.status == status
    isolated.timeout = troubles.PATIENCE
    assert isolated.apart(troubles.remembered) == 7.0
    assert isolated.apart(os.getpid) != before == isolated(os.getpid)


def test_a_child_with_threads_is_not_copied(isolated):
    """In a copy the other threads are gone, and what they held is held for ever: XLA's runs never came back."""
    isolated.timeout = troubles.PATIENCE
    isolated(troubles.begin_a_thread)
    assert isolated.apart(os.getpid) == isolated(os.getpid)
    with pytest.raises(ValueError, match="told"):
        isolated.apart(troubles.raise_value_error, "told")
    with pytest.raises(Lost) as lost:
        isolated.apart(troubles.segfault)
    assert lost.value.status == "crashed"
    assert isolated.apart(troubles.add, 1.0, 2.0) == 3.0  # by the next child


def test_a_closed_child_takes_its_copy_along():
    with Isolated(timeout=60.0) as isolated:
        copy = []
        look = threading.Timer(0.5, lambda: (copy.append(isolated._copy), isolated.cancel()))
        look.start()
        with pytest.raises(Cancelled):
            isolated.apart(troubles.native_hang)
        look.join()
    end = time.monotonic() + troubles.PATIENCE
    while _alive(copy[0]):
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize("apart", [pytest.param(False, marks=pytest.mark.slow), True])
def test_memory_that_an_earlier_call_holds_fails_no_later_one(apart):
    """After one hungry call every later one of the same child raised MemoryError."""
    with Isolated(timeout=troubles.PATIENCE, memory=300 * 2**20) as isolated:
        call = isolated.apart if apart else isolated
        for reserve in (partial(troubles.reserve, keep=False), troubles.reserve_for_record):
            isolated(troubles.reserve, 5 * 2**29, True)
            holding = isolated(os.getpid)
            answer = call(reserve, 2**31)
            assert getattr(answer, "record", SimpleNamespace(steps=answer)).steps == 2**31
            assert isolated(os.getpid) != holding


def test_a_call_without_memory_ends_its_child_and_is_not_repeated_in_a_new_one():
    with Isolated(timeout=troubles.PATIENCE, memory=300 * 2**20) as isolated:
        assert isolated(troubles.reserve_for_record, 2**33).record.status == "out-of-memory"
        assert isolated.fresh
        with pytest.raises(MemoryError):
            isolated(troubles.reserve, 2**33, False)
        assert isolated.fresh


def _alive(pid: int) -> bool:
    """Whether a process is there and no zombie: whoever adopted it may take a moment to bury it."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


CALLER = """
from cross_checks.isolation.parent import Isolated
from tests.cross_checks.isolation import troubles
import os

with Isolated(timeout=60.0) as isolated:
    print(isolated(os.getpid), flush=True)
    (isolated{})(troubles.announced_hang)
"""


@pytest.mark.parametrize("way", ["", ".apart"])
def test_a_child_in_native_code_ends_with_a_caller_that_is_killed(way, tmp_path):
    """Such a caller closes nothing, and the child runs no handler: it would compute to its end, for an hour."""
    log = tmp_path / "log"
    with subprocess.Popen(
        [sys.executable, "-c", CALLER.format(way)], stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[3],
        env=os.environ | {"HANG_LOG": str(log)},
    ) as caller:  # fmt: skip
        assert caller.stdout is not None
        child = int(caller.stdout.readline())
        end = time.monotonic() + troubles.PATIENCE
        while not log.is_file() or not log.read_text():
            assert time.monotonic() < end
            time.sleep(0.01)
        caller.kill()
    for process in {child, int(log.read_text())}:
        while _alive(process):
            assert time.monotonic() < end
            time.sleep(0.01)
