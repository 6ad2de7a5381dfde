"""The numbers of a file by the names of their columns: CSV, NPZ or Parquet."""

import csv
import importlib
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mbs_ref.trajectory import POSES, pose_columns

SUFFIXES = (".csv", ".txt", ".tsv", ".npz", ".parquet")


OWN = {"bodies", "times", *POSES}  # in the files that `mbs-ref simulate -o` writes


class FileError(ValueError):
    """A file cannot be read as a trajectory; the sentence names the line, the column and what is expected."""


class Columns(NamedTuple):
    """A table of numbers."""

    path: Path
    values: dict[str, np.ndarray]  # column -> (n_rows,)
    lines: tuple[int, ...] = ()  # of the file, where each row stands; none where the file has no lines

    def place(self, row: int, column: str) -> str:
        """Return where a number stands, for a sentence."""
        line = f"line {self.lines[row]}" if self.lines else f"row {row}"
        return f"{self.path.name}: {line}, column {column!r}"


def read_columns(path: Path, delimiter: str = ",") -> Columns:
    """Read a file's columns.

    Raises FileError: not a file, an unknown suffix, no row, a row that is too short or too long, a cell that is no
    finite number, a column that stands twice.
    """
    if path.suffix not in SUFFIXES:
        raise FileError(f"{path}: suffix {path.suffix!r} is unknown; allowed: {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise FileError(f"{path}: there is no such file")
    readers = {".npz": _npz, ".parquet": _parquet}
    return _checked(readers[path.suffix](path) if path.suffix in readers else _text(path, delimiter))


def columns_of(arrays: Mapping[str, np.ndarray]) -> Columns:
    """Return arrays as columns, as those of an NPZ file: (n_rows,) is one, (n_rows, k) are name[0] to name[k - 1].

    Raises FileError as `read_columns` does.
    """
    return _checked(_of_arrays(Path("arrays"), arrays))


def _checked(table: Columns) -> Columns:
    path = table.path
    if not table.values or not len(next(iter(table.values.values()))):
        raise FileError(f"{path}: holds no row of numbers; expected: a header and a row a time")
    for name, values in table.values.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise FileError(f"{table.place(int(bad[0]), name)}: {values[bad[0]]} is not finite")
    return table


def read_header(path: Path) -> list[str]:
    """Return the names of a file's columns. Raises FileError."""
    return list(read_columns(path).values)


def _text(path: Path, delimiter: str) -> Columns:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(f"{path}: byte {error.start} is not UTF-8 text") from error
    rows = csv.reader(text.splitlines(), delimiter=delimiter, skipinitialspace=True)
    lines = ((rows.line_num, [cell.strip() for cell in row]) for row in rows)
    filled = [(line, row) for line, row in lines if any(row) and not row[0].startswith("#")]
    if not filled:
        raise FileError(f"{path}: is empty; expected: a header and a row a time")
    names = _checked_header(path, *filled[0])
    numbers = np.array([list(_numbers(path, line, row, names)) for line, row in filled[1:]]).reshape(-1, len(names))
    return Columns(path, dict(zip(names, numbers.T, strict=True)), tuple(line for line, _ in filled[1:]))


def _checked_header(path: Path, line: int, names: list[str]) -> list[str]:
    if all(_number(name) is not None for name in names):
        raise FileError(f"{path.name}: line {line} holds numbers; expected: the names of the columns")
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise FileError(f"{path.name}: line {line}, column {twice[0]!r} stands {names.count(twice[0])} times")
    return names


def _numbers(path: Path, line: int, row: list[str], names: list[str]) -> Iterator[float]:
    if len(row) != len(names):
        problem = f"{len(row)} cells; expected: {len(names)}, as in the header"
        raise FileError(f"{path.name}: line {line} has {problem}")
    for name, cell in zip(names, row, strict=True):
        value = _number(cell)
        if value is None:
            raise FileError(f"{path.name}: line {line}, column {name!r}: {cell!r} is no number")
        yield value


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def _npz(path: Path) -> Columns:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return _of_arrays(path, {name: arrays[name] for name in arrays.files})
    except (ValueError, OSError) as error:
        raise FileError(f"{path}: cannot be read as NPZ: {error}") from error


def _of_arrays(path: Path, held: Mapping[str, np.ndarray]) -> Columns:
    if held.keys() >= OWN:
        return Columns(path, _of_one_length(path, _own(held)))
    values = {}
    for name, array in held.items():
        if array.dtype.kind in "fiu" and array.ndim == 1:
            values[name] = array.astype(float)
        elif array.dtype.kind in "fiu" and array.ndim == 2:
            values |= {f"{name}[{k}]": column.astype(float) for k, column in enumerate(array.T)}
    return Columns(path, _of_one_length(path, values))


def _own(held: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns of an NPZ that `mbs-ref simulate -o` wrote, named as in its CSV."""
    bodies = [str(body) for body in held["bodies"]]
    return {"t": held["times"], **pose_columns(bodies, (held[name] for name in POSES))}


def _parquet(path: Path) -> Columns:
    try:
        parquet = importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise FileError(f"{path}: Parquet needs the package pyarrow: pip install pyarrow") from error
    try:
        held = parquet.read_table(path)
    except (OSError, ValueError) as error:  # pyarrow's own errors are of these classes
        raise FileError(f"{path}: cannot be read as Parquet: {error}") from error
    numeric = {name: held[name].to_numpy() for name in held.column_names}
    return Columns(path, {name: v.astype(float) for name, v in numeric.items() if v.dtype.kind in "fiu"})


def _of_one_length(path: Path, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    lengths = {name: len(column) for name, column in values.items()}
    if len(set(lengths.values())) > 1:
        problem = ", ".join(f"{name}: {length}" for name, length in lengths.items())
        raise FileError(f"{path}: columns differ in length ({problem})")
    return values


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
