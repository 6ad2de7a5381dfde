"""The search against full ladders: it finds what they find, at the error asked, in fewer runs.

Measured on all default scenes: 1376 runs against 2461, one target of 555 missed, 45 choices of 627 further below their
target than requested: more than the bounds below.
"""

from __future__ import annotations

import pytest

from cross_checks.isolation.parent import Isolated
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store, default_path
from reports.gather import SCENES
from tests.cross_checks.judge.search_against_ladders import compared, summary

FEWER = 0.54  # of the ladders' runs
MISSED = 0.005  # of the targets that a rung reaches
FAR = 0.02  # of the choices


@pytest.mark.slow
def test_the_search_finds_what_full_ladders_find_in_about_half_the_runs():
    with Store(default_path()) as store, Isolated() as call:
        runs = Runs(store, call)
        found = summary(cell for name, parameters in SCENES for cell in compared(runs, name, parameters))
    assert len(found.missed) <= MISSED * found.targets, found.missed
    assert len(found.far) <= FAR * found.choices, found.far
    assert found.searched <= FEWER * found.climbed
