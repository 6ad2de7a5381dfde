"""The columns of a file or of arrays by their names, thinned where they have more rows than are judged; units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cross_checks.trajectory_files.formats import FileError, Rows, parts, rows_of

MOST_ROWS = 10_000  # that are judged of those that stand at regular places
NONE = 2**62  # a stride that leaves no row but the first
Only = tuple[np.ndarray, float]  # times of the rows that are wanted, and how far off they may be, in the file's unit
Report = Callable[[int, int, str], None]  # done, total, what


class Columns(NamedTuple):
    """A table of numbers."""

    path: Path
    values: dict[str, np.ndarray]  # column -> (n_rows,)
    numbers: np.ndarray | None = None  # (n_rows,) lines of the file, or places among its rows
    word: str = "row"  # what the numbers count
    total: int = 0  # rows of the file
    stride: int = 1  # of every how many rows one is here

    def place(self, row: int, column: str) -> str:
        """Return where a number stands, for a sentence."""
        number = row if self.numbers is None else self.numbers[row]
        return f"{self.path.name}: {self.word} {number}, column {column!r}"

    def at(self, rows: np.ndarray) -> Columns:
        """Return the table of some of its rows, given by their places (n,)."""
        values = {name: column[rows] for name, column in self.values.items()}
        return self._replace(values=values, numbers=rows if self.numbers is None else self.numbers[rows])

    @property
    def thinned(self) -> tuple[str, ...]:
        """A sentence where not every row is judged."""
        if self.stride == 1:
            return ()
        count = len(next(iter(self.values.values())))
        every = f"every {self.stride}th, and of each part of the file the one at which a column bends most"
        return (f"{count} of {self.total} rows of {self.path.name} are judged: {every}",)


def read_columns(
    path: Path, delimiter: str = ",", clock: str = "t", only: Only | None = None, report: Report | None = None
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
    return _kept(path, [rows_of(path, arrays)], clock, only, None)


def read_header(path: Path) -> list[str]:
    """Return the names of a file's columns. Raises FileError."""
    return next(iter(parts(path))).names


class _Part(NamedTuple):
    places: np.ndarray  # (n,) among all rows
    marked: np.ndarray  # (n,) which remain in any case
    rows: Rows

    def thinned(self, stride: int) -> _Part:
        keep = self.marked | (self.places % stride == 0)
        rows = self.rows._replace(table=self.rows.table[keep], numbers=self.rows.numbers[keep])
        return _Part(self.places[keep], self.marked[keep], rows)


def _kept(path: Path, every: Iterable[Rows], clock: str, only: Only | None, report: Report | None) -> Columns:
    kept: list[_Part] = []
    total, stride, before = 0, 1 if only is None else NONE, -np.inf
    for rows in every:
        before = _checked(path, rows, clock, before)
        kept.append(_Part(total + np.arange(len(rows.table)), _marked(rows, clock, only), rows))
        total += len(rows.table)
        while sum(np.count_nonzero(part.places % stride == 0) for part in kept) > MOST_ROWS:
            stride *= 2
        kept = [part.thinned(stride) for part in kept]
        if report is not None:
            report(int(100.0 * rows.share), 100, f"percent, {total} rows")
    if total == 0 or not kept[0].rows.names:
        raise FileError(f"{path}: holds no row of numbers; expected: a header and a row a time")
    table, numbers = (np.concatenate([getattr(part.rows, name) for part in kept]) for name in ("table", "numbers"))
    values = dict(zip(kept[0].rows.names, table.T, strict=True))
    return Columns(path, values, numbers, kept[0].rows.word, total, 1 if stride == NONE else stride)


def _marked(part: Rows, clock: str, only: Only | None) -> np.ndarray:
    """Return which rows remain in any case (n,)."""
    marked = np.zeros(len(part.table), dtype=bool)
    if only is None:
        marked[-1:] = True
        if len(part.table) > 2:
            bends = np.abs(np.diff(part.table, 2, axis=0))
            typical = bends.mean(axis=0)
            marked[1 + np.argmax(np.max(bends / np.where(typical > 0.0, typical, 1.0), axis=1))] = True
    elif clock in part.names and len(only[0]):
        times, wanted = part.table[:, part.names.index(clock)], np.pad(only[0], 1, constant_values=(-np.inf, np.inf))
        after = np.searchsorted(wanted, times)
        marked = np.minimum(wanted[after] - times, times - wanted[after - 1]) <= only[1]
    return marked


def _checked(path: Path, part: Rows, clock: str, before: float) -> float:
    """Raise FileError where a number is not finite or the clock goes back; return the clock's last value."""
    bad = np.argwhere(~np.isfinite(part.table))
    if len(bad):
        row, column = bad[0]
        raise FileError(f"{part.place(path, row, part.names[column])}: {part.table[row, column]} is not finite")
    if clock not in part.names or not len(part.table):
        return before
    times = part.table[:, part.names.index(clock)]
    back = is_increasing(np.append(before, times))
    if back is not None:
        earlier = before if back == 1 else times[back - 2]
        raise FileError(
            f"{part.place(path, back - 1, clock)}: {times[back - 1]:g} follows {earlier:g}; times must increase"
        )
    return float(times[-1])


def is_increasing(times: np.ndarray) -> int | None:
    """Return the first row whose time is not above the one before; None where all are."""
    back = np.flatnonzero(np.diff(times) <= 0.0)
    return int(back[0]) + 1 if len(back) else None


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
