"""What a record's run cost, and whether it may be ranked."""

from collections.abc import Iterable, Sequence

from cross_checks.records.record import Record
from mbs_ref.trajectory import Status

BUSY_NOTE = "timed on a busy machine"


def usable(record: Record) -> bool:
    """Return whether the run finished, was measured against a truth, and has a loop time."""
    return record.status == Status.SUCCESS and record.error is not None and record.times.get("loop_s", 0.0) > 0.0


def known_error(record: Record) -> float:
    """Return the error with the truth's uncertainty added."""
    assert record.error is not None
    return record.error.bound


def floor(records: Iterable[Record]) -> float:
    """Return the uncertainty of the records' truth, below which it resolves no error."""
    return max((record.error.uncertainty for record in records if record.error), default=0.0)


def loop_time(record: Record) -> float:
    """Return the loop time (s) by which runs are ranked."""
    return record.times.get("loop_s", float("inf"))


def is_timed(record: Record) -> bool:
    """Whether the loop was timed alone, several times."""
    return "loop_runs" in record.times


def is_busy(record: Record) -> bool:
    """Whether the loop was timed while others used the machine."""
    return BUSY_NOTE in record.notes


def best_of_engines(records: Sequence[Record], target: float = 1e-6) -> list[Record]:
    """Return one record for each engine: its cheapest within `target`, else its most accurate, else its last."""

    def preference(record: Record) -> tuple[int, float]:
        if not usable(record):
            return (2, 0.0)
        error = known_error(record)
        return (0, loop_time(record)) if error <= target else (1, error)

    names = dict.fromkeys(record.engine for record in records)
    return [min((r for r in reversed(records) if r.engine == name), key=preference) for name in names]
