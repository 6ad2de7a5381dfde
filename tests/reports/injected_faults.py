"""Faults on purpose: the calls of our own files that open, write, allocate or import, and one of them made to fail."""

from __future__ import annotations

import builtins
import errno
import io
import linecache
import os
import sqlite3
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
OURS = tuple(f"{ROOT / package}{os.sep}" for package in ("mbs_ref", "cross_checks", "reports", "benchmarks"))


class Place(NamedTuple):
    """A call in one of our files."""

    kind: str
    file: str
    line: int


def _refused() -> OSError:
    return OSError(errno.ENOSPC, "No space left on device", "a-file")


FAULTS: dict[str, Callable[[], BaseException]] = {
    "open": lambda: PermissionError(errno.EACCES, "Permission denied", "a-file"),
    "write": _refused,
    "base": lambda: sqlite3.OperationalError("database or disk is full"),
    "memory": lambda: MemoryError("Unable to allocate 9 GiB"),
    "import": lambda: ImportError("No module named 'absent'", name="absent"),
}
ALLOCATE = (
    "empty", "empty_like", "zeros", "zeros_like", "ones", "full", "full_like", "array", "stack", "column_stack",
    "concatenate", "append", "arange", "linspace", "geomspace", "repeat", "union1d", "unique", "where", "pad",
)  # fmt: skip
CALLS = (
    ("open", builtins, "open"), ("open", io, "open"), ("open", os, "open"), ("write", os, "fsync"),
    ("write", os, "replace"), ("write", os, "mkdir"), ("import", builtins, "__import__"),
    *(("memory", np, name) for name in ALLOCATE),
)  # fmt: skip


class Gate:
    """Notes every place that is passed, and raises at one of them."""

    def __init__(self, at: Place | None = None) -> None:
        self.at, self.passed = at, dict[Place, None]()
        self.raised = False

    def __call__(self, kind: str) -> None:
        frame = sys._getframe(2)
        while frame is not None and not frame.f_code.co_filename.startswith(OURS):
            if kind in ("memory", "import"):  # of a library's own
                return
            frame = frame.f_back
        if frame is None:
            return
        code = linecache.getline(frame.f_code.co_filename, frame.f_lineno)
        if kind == "import" and "import" not in code:  # a pickled function names its module, which is loaded
            return
        place = Place(kind, os.path.relpath(frame.f_code.co_filename, ROOT), frame.f_lineno)
        self.passed[place] = None
        if place == self.at and not self.raised:
            self.raised = True
            raise FAULTS[kind]()


@contextmanager
def injected(gate: Gate) -> Iterator[None]:
    """Pass every call of CALLS, and every statement of a database, through the gate."""

    def gated(kind: str, real: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any, **named: Any) -> Any:
            gate(kind)
            return real(*given, **named)

        return call

    class Base(sqlite3.Connection):
        def execute(self, *given: Any) -> Any:
            gate("base")
            return super().execute(*given)

    connect = sqlite3.connect

    def connected(*given: Any, **named: Any) -> Any:
        gate("base")
        return connect(*given, factory=Base, **named)

    with pytest.MonkeyPatch.context() as patch:
        for kind, module, name in CALLS:
            patch.setattr(module, name, gated(kind, getattr(module, name)))
        patch.setattr(sqlite3, "connect", connected)
        yield
