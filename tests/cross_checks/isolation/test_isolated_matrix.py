"""An engine that crashes, hangs or eats memory inside a matrix or a sweep costs its own cell, and the rest goes on."""

from __future__ import annotations

import pytest

from cross_checks.isolation.parent import Isolated
from cross_checks.judge.runs import Runs
from mbs_ref import scenes
from mbs_ref.settings import Settings
from tests.cross_checks.isolation import troubles

CASES = [(troubles.native_hang, "timeout"), (troubles.segfault, "crashed"), (troubles.abort, "crashed"),
         *(pytest.param(*case, marks=pytest.mark.slow) for case in (
             (troubles.eat_memory, "out-of-memory"), (troubles.hang, "timeout")))]  # fmt: skip


@pytest.fixture(scope="module")
def isolated():
    with Isolated(memory=300 * 2**20) as call:
        yield call


@pytest.mark.parametrize(("trouble", "status"), CASES)
def test_only_its_own_cell_is_lost(isolated, trouble, status):
    def call(function, *arguments):
        return isolated(trouble)  # in place of the engine's run

    isolated.timeout = troubles.patience(status)
    runs = Runs(call=call)
    record = runs.run(scenes.make("pendulum"), "mbs_ref", Settings(method="rk4", step=0.01)).record
    assert record.status == status
    assert record.message
    assert len(runs.store) == (status == "crashed")  # what the machine had no time or memory for may run on another
    isolated.timeout = troubles.PATIENCE
    assert isolated(troubles.add, 1.0, 1.0) == 2.0
