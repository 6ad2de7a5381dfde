"""No run misses an event or invents one, whatever its outputs."""

from __future__ import annotations

import pytest

from mbs_ref.simulate import simulate_scenes
from mbs_ref.simulate.many.lanes import NOTE
from tests.mbs_ref.hidden_events.__main__ import METHODS, Way, compare_one
from tests.mbs_ref.hidden_events.cases import Comparison, case, compare
from tests.mbs_ref.hidden_events.families import FAMILIES

CELLS = [(family, method) for family in FAMILIES for method in METHODS]
QUICK = [cell for cell in CELLS if cell[1] in ("dop853", "dassl") and cell != ("studs", "dassl")]
GOOD = {"good", "undecided"}
# A point deeper than 1 m below a line without ends; impacts whose impulse all but acts through a joint.
HARD = [("turning", 402), ("grazing", 10000), ("grazing", 10008), ("grazing", 10014)]


def _failures(family: str, method: str, seeds: range, outputs: tuple[int, ...]) -> dict[tuple[int, int], Comparison]:
    runs = {
        (seed, count): compare_one(case(family, seed), Way(method, count)) for seed in seeds for count in outputs
    }  # fmt: skip
    return {key: each for key, each in runs.items() if each.verdict not in GOOD}


@pytest.mark.parametrize(("family", "method"), QUICK)
def test_no_event_of_a_few_scenes_is_missed_or_invented(family, method):
    assert _failures(family, method, range(1), (2, 101)) == {}


@pytest.mark.parametrize(("family", "seed"), HARD)
def test_events_that_are_hard_to_locate_are_good(family, seed):
    assert _failures(family, "dop853", range(seed, seed + 1), (2,)) == {}


@pytest.mark.parametrize("family", FAMILIES)
def test_no_event_is_missed_or_invented_in_lanes(family):
    hidden = case(family, 41000)
    paths = simulate_scenes([hidden.scene] * 2, hidden.settings("dop853", 2), threads=1, lanes=True)
    assert all(path.notes[0].startswith(NOTE) for path in paths)
    assert {compare(hidden, path, "dop853").verdict for path in paths} == {"good"}


@pytest.mark.slow
@pytest.mark.parametrize(("family", "method"), CELLS)
def test_no_event_of_many_scenes_is_missed_or_invented(family, method):
    assert _failures(family, method, range(40), (2, 101)) == {}
