"""A call that hangs, crashes or eats memory costs itself, and the next call works."""

from __future__ import annotations

import threading

import pytest

from cross_checks.isolation import Cancelled, Isolated, Lost
from tests.cross_checks import troubles


@pytest.fixture(scope="module")
def call():
    with Isolated(timeout=2.0, memory=300 * 2**20) as isolated:
        yield isolated


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
def test_what_is_lost_is_named_and_the_next_call_works(call, trouble, status, words):
    with pytest.raises(Lost, match=words) as lost:
        call(trouble)
    assert lost.value.status == status
    assert call(troubles.add, 1.0, 1.0) == 2.0


def test_a_cancelled_call_ends_and_no_other_starts():
    with Isolated(timeout=60.0) as isolated:
        threading.Timer(0.3, isolated.cancel).start()
        for _ in range(2):
            with pytest.raises(Cancelled):
                isolated(troubles.hang)
