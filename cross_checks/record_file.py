"""Records on disk: JSON lines, appended whole, and a corrupt line costs only itself."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from cross_checks.record import Error, Record


def append(path: Path, records: Iterable[Record]) -> None:
    """Append records, each in a single write that other processes cannot tear apart.

    ValueError where a record holds NaN or infinity: those have no place in JSON.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
    try:
        for record in records:
            line = json.dumps(record.to_dict(), allow_nan=False, separators=(",", ":")) + "\n"
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
    records, problems = [], []
    for number, line in enumerate(path.read_bytes().split(b"\n"), start=1):
        if not line.strip():
            continue
        try:
            records.append(from_dict(json.loads(line, parse_constant=_refuse)))
        except (ValueError, TypeError) as error:  # UnicodeDecodeError and JSONDecodeError are ValueErrors
            problems.append(f"{path}:{number}: no record, skipped: {error}")
    return records, problems


def from_dict(data: Any) -> Record:
    """Return the record that to_dict() gave; TypeError names missing or unknown fields."""
    if not isinstance(data, dict):
        raise TypeError(f"a record is an object, and this is {type(data).__name__}")
    error = data.get("error")
    plain = data | {"error": Error(**error) if error else None, "notes": tuple(data.get("notes", ()))}
    return Record(**plain)


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a number a record may hold")
