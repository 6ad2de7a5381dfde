"""The list of seeded defects: they can be written into the sources, and tests that exist watch them."""

from __future__ import annotations

import pytest

from tests.mutants import watchers
from tests.mutants.defect import ROOT, Defect, StaleError, every, place

LEAST = 300  # defects that can be written into the sources as they are


def test_enough_defects_find_their_place():
    found = every()
    assert len({defect.name for defect in found}) == len(found)
    assert sum(_is_written(defect) for defect in found) >= LEAST


def _is_written(defect: Defect) -> bool:
    try:
        source = place(defect, ROOT).read_text()
    except StaleError:
        return False
    compile(source.replace(defect.old, defect.new), defect.file, "exec")
    return defect.new != defect.old


@pytest.mark.parametrize("prefix", watchers.WATCHERS)
def test_the_tests_that_watch_exist(prefix):
    for tests in watchers.tests_for(prefix):
        assert (ROOT / tests).exists(), tests
