"""The rows of a file in parts of bounded size: CSV, NPZ or Parquet."""

import csv
import importlib
import io
import math
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import batched
from pathlib import Path
from typing import IO

import numpy as np

from mbs_ref.trajectory import POSES, pose_columns

DELIMITERS = ",;\t"  # of a CSV; the one that its header has most, unless stated
SUFFIXES = (".csv", ".txt", ".tsv", ".npz", ".parquet")
OWN = {"bodies", "times", *POSES}  # in the files that `mbs-ref simulate -o` writes
PART = 2**18  # numbers in memory


class FileError(ValueError):
    """A file cannot be read as a trajectory; the sentence names the line, the column and what is expected."""


@dataclass(frozen=True)
class Columns:
    """A table of numbers, or a part of one."""

    path: Path
    values: dict[str, np.ndarray]  # column -> (n_rows,)
    numbers: np.ndarray | None = None  # (n_rows,) lines of the file, or places among its rows
    word: str = "row"  # what the numbers count
    total: int = 0  # rows of the file
    stride: int = 1  # of every how many rows one is here
    share: float = 1.0  # of the file that is read by its end

    def __len__(self) -> int:
        return len(next(iter(self.values.values()), ()))

    @property
    def counted(self) -> np.ndarray:
        """The lines, or places, of all rows (n_rows,)."""
        return np.arange(len(self)) if self.numbers is None else self.numbers

    def place(self, row: int, column: str) -> str:
        """Return where a number stands, for a sentence."""
        return f"{self.path.name}: {self.word} {self.counted[row]}, column {column!r}"

    def at(self, rows: np.ndarray) -> "Columns":
        """Return some of the rows, given by their places or a mask (n,)."""
        return replace(self, values={k: v[rows] for k, v in self.values.items()}, numbers=self.counted[rows])


def parts(path: Path, delimiter: str = "") -> Iterator[Columns]:
    """Yield the rows of a file, PART numbers at a time.

    Raises FileError: no file, an unknown suffix, rows of unequal length, a cell that is no number, a column that
    stands twice.
    """
    if path.suffix not in SUFFIXES:
        raise FileError(f"{path}: suffix {path.suffix!r} is unknown; allowed: {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise FileError(f"{path}: not a file" if path.exists() else f"{path}: there is no such file")
    try:
        match path.suffix:
            case ".npz":
                yield from _npz(path)
            case ".parquet":
                yield from _parquet(path)
            case _:
                yield from _text(path, delimiter)
    except FileError:
        raise
    except (OSError, EOFError, ValueError, csv.Error, zipfile.BadZipFile) as error:  # pyarrow's are of these classes
        raise FileError(f"{path}: cannot be read as {path.suffix[1:].upper()}: {error}") from error


def part_of(path: Path, arrays: Mapping[str, np.ndarray]) -> Columns:
    """Return arrays as columns: (n_rows,) is one, (n_rows, k) are name[0] to name[k - 1]; raises FileError."""
    columns = _own(arrays) if arrays.keys() >= OWN else _numeric(arrays)
    _check_lengths(path, {name: len(column) for name, column in columns.items()})
    return Columns(path, columns)


def _check_lengths(path: Path, lengths: Mapping[str, int]) -> None:
    if len(set(lengths.values())) > 1:
        problem = ", ".join(f"{name}: {length}" for name, length in lengths.items())
        raise FileError(f"{path}: columns differ in length ({problem})")


def _numeric(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    values = {}
    for name, array in arrays.items():
        if array.dtype.kind in "fiu" and array.ndim == 1:
            values[name] = array.astype(float)
        elif array.dtype.kind in "fiu" and array.ndim == 2:
            values |= {f"{name}[{k}]": column.astype(float) for k, column in enumerate(array.T)}
    return values


def _own(held: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the columns of an NPZ that `mbs-ref simulate -o` wrote, named as in its CSV."""
    bodies = [str(body) for body in held["bodies"]]
    return {"t": held["times"], **pose_columns(bodies, (held[name] for name in POSES))}


def _text(path: Path, delimiter: str) -> Iterator[Columns]:
    with path.open("rb") as raw, io.TextIOWrapper(raw, encoding="utf-8-sig", newline="") as file:
        head = next((text for text in file if text.strip() and not text.lstrip().startswith("#")), "")
        file.seek(0)
        rows = csv.reader(file, delimiter=delimiter or max(DELIMITERS, key=head.count), skipinitialspace=True)
        stripped = ((rows.line_num, [cell.strip() for cell in row]) for row in rows)
        filled = ((line, row) for line, row in stripped if any(row) and not row[0].startswith("#"))
        line, names = next(filled, (0, []))
        if not names:
            raise FileError(f"{path}: is empty; expected: a header and a row a time")
        _check_header(path, line, names)
        for part in batched(filled, max(PART // len(names), 1)):
            table = np.array([_numbers(path, line, row, names) for line, row in part])
            values, lines = dict(zip(names, table.T, strict=True)), np.array([line for line, _ in part])
            yield Columns(path, values, lines, "line", share=min(raw.tell() / path.stat().st_size, 1.0))


def _check_header(path: Path, line: int, names: list[str]) -> None:
    if all(_number(name) is not None for name in names):
        raise FileError(f"{path.name}: line {line} holds numbers; expected: the names of the columns")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise FileError(f"{path.name}: line {line}, column {twice[0]!r} stands {names.count(twice[0])} times")


def _numbers(path: Path, line: int, row: list[str], names: list[str]) -> list[float]:
    if len(row) != len(names):
        problem = f"{len(row)} cells; expected: {len(names)}, as in the header"
        raise FileError(f"{path.name}: line {line} has {problem}")
    try:
        return [float(cell) for cell in row]
    except ValueError:
        name, cell = next(pair for pair in zip(names, row, strict=True) if _number(pair[1]) is None)
        raise FileError(f"{path.name}: line {line}, column {name!r}: {cell!r} is no number") from None


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


class _Member:
    """An array of an NPZ file, read row by row; one that is stored column by column is read whole."""

    def __init__(self, file: IO[bytes]) -> None:
        version = np.lib.format.read_magic(file)
        read = {(1, 0): np.lib.format.read_array_header_1_0}.get(version, np.lib.format.read_array_header_2_0)
        self.shape, by_column, self.dtype = read(file)
        if self.dtype.hasobject:
            raise ValueError("an array of Python objects")
        self.file, self.at, self.whole = file, 0, None
        if by_column and len(self.shape) > 1:
            self.whole = np.frombuffer(file.read(), self.dtype).reshape(self.shape, order="F")

    def rows(self, count: int) -> np.ndarray:
        self.at += count
        if self.whole is not None:
            return self.whole[self.at - count : self.at]
        wanted = min(count, self.shape[0] - self.at + count)
        size = self.dtype.itemsize * math.prod(self.shape[1:])
        return np.frombuffer(self.file.read(wanted * size), self.dtype).reshape(wanted, *self.shape[1:])


def _npz(path: Path) -> Iterator[Columns]:
    with zipfile.ZipFile(path) as archive:
        held = {name.removesuffix(".npy"): _Member(archive.open(name)) for name in archive.namelist()}
        labels = {"bodies": held["bodies"].rows(2**31)} if held.keys() >= OWN else {}
        wanted = OWN - {"bodies"} if labels else {k for k, m in held.items() if m.dtype.kind in "fiu"}
        held = {name: held[name] for name in held if name in wanted and len(held[name].shape) in (1, 2, 3)}
        lengths = {name: member.shape[0] for name, member in held.items()}
        _check_lengths(path, lengths)
        total, width = max(lengths.values(), default=0), sum(math.prod(member.shape[1:]) for member in held.values())
        count = max(PART // max(width, 1), 1)
        for start in range(0, total, count):
            part = part_of(path, labels | {name: member.rows(count) for name, member in held.items()})
            yield _placed(part, start, total)


def _parquet(path: Path) -> Iterator[Columns]:
    try:
        parquet = importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise FileError(f"{path}: Parquet needs the package pyarrow: pip install pyarrow") from error
    file, start = parquet.ParquetFile(path), 0
    for batch in file.iter_batches(batch_size=max(PART // max(len(file.schema_arrow.names), 1), 1)):
        part = part_of(
            path, {k: v.to_numpy(zero_copy_only=False) for k, v in zip(batch.schema.names, batch, strict=True)}
        )
        yield _placed(part, start, file.metadata.num_rows)
        start += len(part)


def _placed(part: Columns, start: int, total: int) -> Columns:
    end = start + len(part)
    return replace(part, numbers=np.arange(start, end), share=end / total)
