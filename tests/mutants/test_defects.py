"""The list of seeded defects: they can be written into the sources, and tests that exist watch them."""

from __future__ import annotations

import tomllib

import pytest

from tests.mutants import watchers
from tests.mutants.defect import ROOT, Defect, every, place, stale


def test_every_defect_finds_its_place():
    found = every()
    assert len({defect.name for defect in found}) == len(found)
    outdated = stale(found)
    assert not outdated, "renew them with python -m tests.mutants.operators:\n" + "\n".join(outdated)


def test_every_defect_changes_a_source_that_still_compiles():
    for defect in every():
        source = place(defect, ROOT).read_text()
        assert defect.new != defect.old
        changed = source.replace(defect.old, defect.new)
        tomllib.loads(changed) if defect.file.endswith(".toml") else compile(changed, defect.file, "exec")


def test_a_defect_whose_text_has_changed_is_named():
    changed = Defect("mbs_ref/settings.py", "no such text", "", "nothing")
    assert stale([every()[0], changed]) == [
        "mbs_ref/settings.py: 'no such text' is found in 0 files; it must be found once"
    ]


@pytest.mark.parametrize("prefix", watchers.WATCHERS)
def test_the_tests_that_watch_exist(prefix):
    for tests in watchers.tests_for(prefix):
        assert (ROOT / tests).exists(), tests
