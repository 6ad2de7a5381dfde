"""The columns of a file or of arrays by their names, thinned where they have more rows than are judged; units."""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from cross_checks.isolation.workers import Report
from cross_checks.trajectory_files.formats import Columns, FileError, part_of, parts

MOST_ROWS = 4000  # that are judged of those that stand at regular places
NO_ROWS = "holds no row of numbers; expected: a header and a row a time"
NONE = 2**62  # a stride that leaves no row but the first
Only = tuple[np.ndarray, float]  # times of the rows that are wanted, and how far off they may be, in the file's unit


def read_columns(
    path: Path, delimiter: str = "", clock: str = "t", only: Only | None = None, report: Report | None = None
) -> Columns:
    """Read a file's columns in bounded memory; more than MOST_ROWS rows are thinned by a power of 2.

    Besides every k-th row, of each part that is read the last one and that with the largest second difference, over
    its column's mean, remain. With `only`, those at the times alone.

    Raises FileError: not a file, an unknown suffix, no row, a row that is too short or too long, a cell that is no
    finite number, a column that stands twice, values of the column `clock` that do not increase.
    """
    return _kept(path, parts(path, delimiter), clock, only, report)


def columns_of(arrays: Mapping[str, np.ndarray], clock: str = "t", only: Only | None = None) -> Columns:
    """Return arrays as columns, as those of an NPZ file: (n_rows,) is one, (n_rows, k) are name[0] to name[k - 1].

    Raises FileError as `read_columns` does, and thins as it does.
    """
    path = Path("arrays")
    return _kept(path, [part_of(path, arrays)], clock, only, None)


def read_header(path: Path, delimiter: str = "") -> Columns:
    """Return a file's columns without rows. Raises FileError."""
    first = next(parts(path, delimiter), None)
    if first is None:
        raise FileError(f"{path}: {NO_ROWS}")
    return first.at(np.arange(0))


def _kept(path: Path, every: Iterable[Columns], clock: str, only: Only | None, report: Report | None) -> Columns:
    kept: list[tuple[Columns, np.ndarray, np.ndarray]] = []  # rows, their places, and which remain in any case
    total, stride, before = 0, 1 if only is None else NONE, -np.inf
    for part in every:
        before = _checked(part, clock, before)
        kept.append((part, total + np.arange(len(part)), _marked(part, clock, only)))
        total += len(part)
        while sum(np.count_nonzero(places % stride == 0) for _, places, _ in kept) > MOST_ROWS:
            stride *= 2
        keep = [marked | (places % stride == 0) for _, places, marked in kept]
        kept = [
            (part.at(own), places[own], marked[own]) for own, (part, places, marked) in zip(keep, kept, strict=True)
        ]
        if report is not None:
            report(total, round(total / part.share), "")
    if total == 0:
        raise FileError(f"{path}: {NO_ROWS}")
    first, stride = kept[0][0], 1 if stride == NONE else stride
    values = {name: np.concatenate([part.values[name] for part, _, _ in kept]) for name in first.values}
    numbers = np.concatenate([part.counted for part, _, _ in kept])
    return Columns(path, values, numbers, first.word, total, stride)


def _marked(part: Columns, clock: str, only: Only | None) -> np.ndarray:
    """Return which rows remain in any case (n,)."""
    marked = np.zeros(len(part), dtype=bool)
    if only is None:
        marked[-1:] = True
        if len(part) > 2:
            bends = [np.abs(np.diff(column, 2)) for column in part.values.values()]
            marked[1 + np.argmax(np.max([bend / (bend.mean() or 1.0) for bend in bends], axis=0))] = True
    elif clock in part.values:
        times, wanted = part.values[clock], np.pad(only[0], 1, constant_values=(-np.inf, np.inf))
        after = np.searchsorted(wanted, times)
        marked = np.minimum(wanted[after] - times, times - wanted[after - 1]) <= only[1]
    return marked


def _checked(part: Columns, clock: str, before: float) -> float:
    """Raise FileError where a number is not finite or the clock goes back; return the clock's last value."""
    for name, column in part.values.items():
        bad = np.flatnonzero(~np.isfinite(column))
        if len(bad):
            raise FileError(f"{part.place(int(bad[0]), name)}: {column[bad[0]]} is not finite")
    times = np.append(before, part.values.get(clock, ()))
    back = np.flatnonzero(np.diff(times) <= 0.0)
    if len(back):
        problem = f"{times[back[0] + 1]:g} follows {times[back[0]]:g}; times must increase"
        raise FileError(f"{part.place(int(back[0]), clock)}: {problem}")
    return float(times[-1])


UNITS = {
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048, "in": 0.0254, "au": 149597870700.0},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "rev": 2.0 * math.pi},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0, "day": 86400.0},
}  # the foot and the inch of 1959, the astronomical unit of IAU 2012 resolution B2
RATES = {"velocity": "length", "angular velocity": "angle"}  # per time


def allowed(kind: str) -> list[str]:
    """Return every unit of a length, angle, time, velocity or angular velocity."""
    if kind in RATES:
        return [f"{above}/{below}" for above in UNITS[RATES[kind]] for below in UNITS["time"]]
    return list(UNITS[kind])


def factor(kind: str, unit: str) -> float:
    """Return how many SI units one `unit` is; ValueError names what is allowed."""
    if unit not in allowed(kind):
        shown = ", ".join(UNITS[RATES.get(kind, kind)])
        per = ", each per s, ms, us, min, h or day, such as deg/s" if kind in RATES else ""
        raise ValueError(f"unit = {unit!r} is no unit of {kind}; allowed: {shown}{per}")
    above, _, below = unit.partition("/")
    return UNITS[RATES.get(kind, kind)][above] / (UNITS["time"][below] if below else 1.0)
