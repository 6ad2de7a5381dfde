"""Two files of records: accuracy decides, time remarks."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.record_changes import Move, alone, changes, median_ratio, overall
from cross_checks.records.record import Error, Record

RECORD = Record(
    scene="pendulum", parameters={"length": 1.0}, engine="swing", method="rk4", settings={"step": 0.01},
    status="success", message="", t_end=1.0, steps=100, rhs_calls=400, final={},
    measures={"compliance_position": 1e-12, "compliance_velocity": 1e-12, "energy_drift": None},
    error=Error(1e-6, "exact: made up", 1e-12, 1e-6), times={"loop_s": 1.0}, versions={},
)  # fmt: skip


def erring(value: float, uncertainty: float = 1e-12) -> Record:
    return replace(RECORD, error=Error(value, "exact: made up", uncertainty, value))


@pytest.mark.parametrize(
    ("new", "move"),
    [
        (RECORD, Move.SAME),
        (erring(1.5e-6), Move.SAME),
        (erring(3e-6), Move.WORSE),
        (erring(1e-7), Move.BETTER),
        (erring(3e-6, uncertainty=4e-6), Move.SAME),  # both are within the truth's uncertainty
        (replace(RECORD, measures={"compliance_position": 1e-9, "compliance_velocity": 0.0}), Move.WORSE),
        (replace(RECORD, measures={"compliance_position": 9e-12, "compliance_velocity": 0.0}), Move.SAME),
        (replace(RECORD, status="diverged"), Move.WORSE),
        (replace(RECORD, status="timeout"), Move.NOT_MEASURED),
        (replace(RECORD, error=None), Move.NOT_MEASURED),
    ],
)
def test_a_run(new, move):
    (change,) = changes([RECORD], [new])
    assert change.move is move
    assert "pendulum" in change.run
    assert change.ratio == pytest.approx(1.0)


@pytest.mark.parametrize(("before", "after", "ratio"), [({}, {"loop_s": 2.0}, None), ({"loop_s": 2.0}, {}, None),
                                                        ({"loop_s": 4.0}, {"loop_s": 2.0}, 0.5)])  # fmt: skip
def test_times_have_a_ratio_where_both_are_known(before, after, ratio):
    (change,) = changes([replace(RECORD, times=before)], [replace(RECORD, times=after)])
    assert change.ratio == ratio


def test_a_failure_that_became_a_success_is_better_and_two_failures_are_the_same():
    failed = replace(RECORD, status="diverged", message="at 1 s")
    assert changes([failed], [RECORD])[0].move is Move.BETTER
    assert changes([failed], [failed])[0].move is Move.SAME


def test_runs_of_one_file_alone_are_counted_and_the_worst_counts():
    other, third = replace(RECORD, settings={"step": 0.1}), replace(RECORD, settings={"step": 0.2})
    assert alone([RECORD, other], [RECORD, third, replace(RECORD, engine="x")]) == (1, 2)
    found = changes([RECORD, other], [erring(1e-3), replace(other, times={"loop_s": 3.0})])
    assert overall(found) is Move.WORSE
    assert median_ratio(found) == pytest.approx(2.0)
    assert overall([]) is Move.NOT_MEASURED


@pytest.mark.parametrize("setting", ["step", "rtol"])
def test_runs_with_two_settings_have_two_names(setting):
    runs = [replace(RECORD, settings={setting: value}, parameters={"links": 7}) for value in (1e-4, 1e-6)]
    names = [change.run for change in changes(runs, runs)]
    assert names == [f"pendulum links=7 swing rk4 {setting}={value}" for value in (1e-4, 1e-6)]
