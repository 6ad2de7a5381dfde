"""Records on disk."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cross_checks.judge.one_run import evaluate
from cross_checks.records.lines import append, read
from mbs_ref import scenes
from mbs_ref.settings import Settings


@pytest.fixture
def record(swing):
    return evaluate(scenes.make("pendulum"), "swing", Settings(step=1e-3))


def test_records_come_back_as_they_were(tmp_path, record):
    path = tmp_path / "new" / "records.jsonl"
    append(path, [record])
    append(path, [record, replace(record, error=None)])
    assert read(path) == ([record, record, replace(record, error=None)], [])
    assert path.read_bytes().count(b"\n") == 3


def test_corrupt_lines_are_reported_with_their_number_and_skipped(tmp_path, record):
    path = tmp_path / "records.jsonl"
    append(path, [record])
    whole = path.read_bytes()
    with path.open("ab") as file:
        file.write(b'{"scene": 1}\n[]\n\xff\xfe\n' + whole.replace(b'"t_end":', b'"t_end":NaN,"x":'))
        file.write(whole[: len(whole) // 2])
    append(path, [record])  # after a torn line
    records, problems = read(path)
    assert records == [record, record]
    assert [text.split(":")[1] for text in problems] == ["2", "3", "4", "5", "6"]


def test_nan_is_never_written(tmp_path, record):
    path = tmp_path / "records.jsonl"
    with pytest.raises(ValueError, match="JSON"):
        append(path, [replace(record, t_end=float("nan"))])
    assert read(path) == ([], [])
