"""No run of a complete family misses an event or invents one, whatever its outputs."""

from __future__ import annotations

import pytest

from tests.mbs_ref.hidden_events.__main__ import METHODS, Way, compare_one
from tests.mbs_ref.hidden_events.cases import Comparison, case
from tests.mbs_ref.hidden_events.families import FAMILIES

# family: methods that detect all its events, each in its time
COMPLETE: dict[str, tuple[str, ...]] = {"springs": METHODS}
CELLS = [(family, method) for family, methods in COMPLETE.items() for method in methods]
GOOD = {"good", "undecided"}


def _failures(family: str, method: str, seeds: range, outputs: tuple[int, ...]) -> dict[tuple[int, int], Comparison]:
    runs = {
        (seed, count): compare_one(case(family, seed), Way(method, count)) for seed in seeds for count in outputs
    }  # fmt: skip
    return {key: each for key, each in runs.items() if each.verdict not in GOOD}


def test_every_cell_is_a_family_and_a_method():
    assert set(COMPLETE) <= set(FAMILIES)
    assert {method for _, method in CELLS} <= set(METHODS)


@pytest.mark.parametrize(("family", "method"), CELLS)
def test_no_event_of_a_complete_family_is_missed_or_invented(family, method):
    assert _failures(family, method, range(6), (2, 101)) == {}


@pytest.mark.slow
@pytest.mark.parametrize(("family", "method"), CELLS)
def test_no_event_of_many_scenes_is_missed_or_invented(family, method):
    assert _failures(family, method, range(300), (2, 101, 20_001)) == {}
