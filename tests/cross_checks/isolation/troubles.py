"""Calls that end badly, importable by name in another process."""

from __future__ import annotations

import ctypes
import os
import signal
import time

from numba.core.event import trigger_event

PATIENCE = 60.0  # s, with what comes back at once but for a busy machine
BRIEF = 2.0  # s, with what never comes back
_held: list[float] = []


def patience(status: str) -> float:
    """Return how long to wait for a call that ends so."""
    return BRIEF if status == "timeout" else PATIENCE


def remember(value: float) -> None:
    _held.append(value)


def remembered() -> float:
    return _held[-1]


def add(a: float, b: float) -> float:
    return a + b


def raise_value_error(text: str) -> None:
    raise ValueError(text)


def hang() -> None:
    time.sleep(60.0)


def compile_slowly(seconds: float) -> str:
    """Do as a compiler does that takes `seconds`, and answer."""
    with trigger_event("numba:compile"), trigger_event("numba:compile"):
        time.sleep(seconds)
    return "compiled"


def compile_and_hang() -> None:
    compile_slowly(0.1)
    hang()


def segfault() -> None:
    ctypes.string_at(0)


def native_hang() -> None:
    """Hold the interpreter's lock in native code, deaf to every signal but SIGKILL."""
    signal.pthread_sigmask(signal.SIG_BLOCK, set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP})
    ctypes.PyDLL(None).sleep(60)


def abort() -> None:
    os.abort()


def leave() -> None:
    os._exit(7)


def eat_memory() -> None:
    held = []
    while True:
        held.append(bytearray(os.urandom(1) * 2**24))  # 16 MiB, touched
        time.sleep(1e-3)
