"""Dataclasses on disk: JSON lines, appended whole, and a corrupt line costs only itself."""

import fcntl
import json
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from cross_checks.records.record import Record

LONGEST_LINE = 64 * 2**20  # bytes; a longer line is no record


class Busy(RuntimeError):
    """Another process is writing the file."""


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return what turns a dataclass into JSON and back."""
    return TypeAdapter(kind)


def append(path: Path, items: Iterable[Any]) -> None:
    """Append dataclasses, each in a single write that other processes cannot tear apart.

    ValueError where one holds NaN or infinity: those have no place in JSON.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT, 0o644)
    try:
        for item in items:
            line = json.dumps(asdict(item), allow_nan=False, separators=(",", ":")) + "\n"
            os.write(handle, ("\n" + line if _is_torn(handle) else line).encode())
        os.fsync(handle)
    finally:
        os.close(handle)


def _is_torn(handle: int) -> bool:
    """Whether an interrupted write left a line without its end."""
    size = os.fstat(handle).st_size
    return size > 0 and os.pread(handle, 1, size - 1) != b"\n"


def read[Item](path: Path, kind: type[Item] = Record) -> tuple[list[Item], list[str]]:  # type: ignore[assignment]
    """Return the dataclasses, and a sentence with file and line number for every line that is none."""
    items, problems = [], []
    for number, line in enumerate(path.read_bytes().split(b"\n"), start=1):
        if not line.strip():
            continue
        try:
            items.append(adapter(kind).validate_python(_parsed(line)))
        except (ValueError, RecursionError) as error:  # UnicodeDecode and JSONDecode are ValueErrors
            problems.append(f"{path}:{number}: no {kind.__name__.lower()}, skipped: {_why(error)}")
    return items, problems


def _why(error: Exception) -> str:
    if not isinstance(error, ValidationError):
        return str(error)
    return "; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}".lstrip(": ") for one in error.errors())


def _parsed(line: bytes) -> Any:
    if len(line) > LONGEST_LINE:
        raise ValueError(f"the line is longer than {LONGEST_LINE // 2**20} MiB")
    return json.loads(line, parse_constant=_refuse)


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
