"""A call that hangs, crashes or eats memory costs itself, and the next call works."""

from __future__ import annotations

import pytest

from cross_checks.isolation import Isolated, Lost
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
