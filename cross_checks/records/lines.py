"""Records on disk: JSON lines, appended whole, and a corrupt line costs only itself."""

import fcntl
import json
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cross_checks.records.record import Error, Record

LONGEST_LINE = 64 * 2**20  # bytes; a longer line is no record


class Busy(RuntimeError):
    """Another process is writing the file."""


def append(path: Path, records: Iterable[Record]) -> None:
    """Append records, each in a single write that other processes cannot tear apart.

    ValueError where a record holds NaN or infinity: those have no place in JSON.
    """
    append_data(path, (record.to_dict() for record in records))


def append_data(path: Path, items: Iterable[dict[str, Any]]) -> None:
    """Append plain data as `append` does records."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
    try:
        for item in items:
            line = json.dumps(item, allow_nan=False, separators=(",", ":")) + "\n"
            os.write(handle, ("\n" + line if _is_torn(handle) else line).encode())
        os.fsync(handle)
    finally:
        os.close(handle)


def _is_torn(handle: int) -> bool:
    """Whether an interrupted write left a line without its end."""
    size = os.fstat(handle).st_size
    return size > 0 and os.pread(handle, 1, size - 1) != b"\n"


def read(path: Path) -> tuple[list[Record], list[str]]:
    """Return the records, and a sentence with file and line number for every line that is none."""
    return read_data(path, from_dict)


def read_data[Item](path: Path, build: Callable[[Any], Item]) -> tuple[list[Item], list[str]]:
    """Return what `build` makes of each line's JSON, and a sentence for every line that it refuses.

    It refuses by a ValueError or TypeError.
    """
    records, problems = [], []
    for number, line in enumerate(path.read_bytes().split(b"\n"), start=1):
        if not line.strip():
            continue
        try:
            records.append(build(_parsed(line)))
        except (ValueError, TypeError, RecursionError) as error:  # UnicodeDecode and JSONDecode are ValueErrors
            problems.append(f"{path}:{number}: no record, skipped: {error}")
    return records, problems


def _parsed(line: bytes) -> Any:
    if len(line) > LONGEST_LINE:
        raise ValueError(f"the line is longer than {LONGEST_LINE // 2**20} MiB")
    return json.loads(line, parse_constant=_refuse)


def from_dict(data: Any) -> Record:
    """Return the record that to_dict() gave; TypeError names missing or unknown fields."""
    if not isinstance(data, dict):
        raise TypeError(f"a record is an object, and this is {type(data).__name__}")
    error = data.get("error")
    plain = data | {"error": Error(**error) if error else None, "notes": tuple(data.get("notes", ()))}
    return Record(**plain)


def key_of(record: Record) -> str:
    """Return what identifies the run: scene, parameters, engine, method and settings."""
    method = record.settings.get("method") or record.method
    settings = {name: value for name, value in record.settings.items() if name != "method"}
    return json.dumps([record.scene, record.parameters, record.engine, method, settings], sort_keys=True)


@contextmanager
def exclusive(path: Path) -> Iterator[None]:
    """Lock a file against other sweeps; the lock ends with its process. Busy where another holds it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        raise Busy(f"{path} is being written by another process") from None
    finally:
        os.close(handle)


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a number a record may hold")
