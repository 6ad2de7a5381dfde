"""Calls that end badly, importable by name in another process."""

from __future__ import annotations

import ctypes
import os
import signal
import time


def add(a: float, b: float) -> float:
    return a + b


def raise_value_error(text: str) -> None:
    raise ValueError(text)


def hang() -> None:
    time.sleep(60.0)


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
