"""What OpenSim counts of a run, which it tells nowhere but in its log."""

from __future__ import annotations

import ctypes
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import opensim  # pyright: ignore[reportMissingImports]

LEVEL = "Error"  # of what OpenSim prints otherwise


class Counts(NamedTuple):
    """Of all integrations since the manager was initialized; zeros where the log does not tell."""

    steps: int = 0
    rhs_calls: int = 0
    rejected_steps: int = 0


def counted(manager: Any, t: float) -> tuple[Any, Counts]:
    """Integrate to time t (s); return the state, and what was counted since the manager was initialized.

    What OpenSim prints beside its log is kept from standard output.
    """
    sink = opensim.StringLogSink()
    opensim.Logger.removeFileSink()
    opensim.Logger.addSink(sink)
    with _unprinted():
        opensim.Logger.setLevelString("Info")
        try:
            state = manager.integrate(t)
        finally:
            opensim.Logger.setLevelString(LEVEL)
            opensim.Logger.removeSink(sink)
    return state, _read(sink.getString())


def _read(log: str) -> Counts:
    steps = re.search(r"steps taken / attempted: (\d+) / (\d+)", log)
    calls = re.search(r"number of realizations: (\d+)", log)
    if steps is None or calls is None:
        return Counts()
    taken, attempted = map(int, steps.groups())
    return Counts(taken, int(calls[1]), attempted - taken)


@contextmanager
def _unprinted() -> Iterator[None]:
    """Send what the process prints to nowhere, native code's prints among it."""
    flush = ctypes.CDLL(None).fflush
    sys.stdout.flush()
    flush(None)
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    try:
        yield
    finally:
        flush(None)
        os.dup2(kept, 1)
        os.close(kept)
