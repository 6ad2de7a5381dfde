"""An engine that crashes, hangs or eats memory inside a matrix or a sweep costs its own cell, and the rest goes on."""

from __future__ import annotations

import pytest

from benchmarks.sweep import measured
from cross_checks.engine import Method
from cross_checks.isolation.parent import Isolated
from cross_checks.judge.matrix import judged
from cross_checks.judge.verdict import Verdict
from mbs_ref import scenes
from mbs_ref.settings import Settings
from tests.cross_checks.isolation import troubles

METHOD = Method("rk4", "fixed", 4, "")
CASES = [(troubles.hang, "timeout"), (troubles.native_hang, "timeout"), (troubles.segfault, "crashed"),
         (troubles.abort, "crashed"), (troubles.eat_memory, "out-of-memory")]  # fmt: skip


@pytest.fixture(scope="module")
def isolated():
    with Isolated(memory=300 * 2**20) as call:
        yield call


@pytest.mark.parametrize(("trouble", "status"), CASES)
def test_only_its_own_cell_is_lost(isolated, trouble, status):
    def call(function, *arguments):
        return isolated(trouble)  # in place of the engine's run

    isolated.timeout = troubles.patience(status)
    scene = scenes.make("pendulum")
    cell = judged(scene, "native", METHOD, 1.0, call)
    record = measured(scene, "native", Settings(method="rk4", step=0.01), call)
    assert (cell.verdict, record.status) == (Verdict(status), status)
    assert cell.reason
    assert record.message
    isolated.timeout = troubles.PATIENCE
    assert isolated(troubles.add, 1.0, 1.0) == 2.0
