"""Calls that end badly, importable by name in another process."""

from __future__ import annotations

import ctypes
import os
import signal
import threading
import time
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numba.core.event import trigger_event

from cross_checks.isolation.parent import Isolated, Lost

PATIENCE = 60.0  # s, with what comes back at once but for a busy machine
BRIEF = 2.0  # s, with what never comes back
_held: list[float] = []
_blocks: list[np.ndarray] = []
_inner: list[Isolated] = []
_lock = threading.Lock()


def patience(status: str) -> float:
    """Return how long to wait for a call that ends so."""
    return BRIEF if status == "timeout" else PATIENCE


def remember(value: float) -> None:
    _held.append(value)


def remembered() -> float:
    return _held[-1]


def begin_a_thread() -> None:
    """Start a thread that holds a lock for good, as those of a library may."""
    taken = threading.Event()

    def hold() -> None:
        with _lock:
            taken.set()
            time.sleep(3600.0)

    threading.Thread(target=hold, daemon=True).start()
    taken.wait()


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


def start_inner() -> float:
    """Start a child of this process, as an engine with an environment of its own has one."""
    _inner.append(Isolated())
    return _inner[-1](add, 1.0, 1.0)


def wait_for_a_compiler(seconds: float) -> str:
    return _inner[-1](compile_slowly, seconds)


def lose_a_compiler() -> None:
    """Outlive a child that compiled until it was lost, and wait for no compiler then."""
    with suppress(Lost):
        _inner[-1](_compile_and_leave)
    hang()


def _compile_and_leave() -> None:
    with trigger_event("numba:compile"):
        time.sleep(0.2)
        leave()


def compile_and_hang() -> None:
    compile_slowly(0.1)
    hang()


def segfault() -> None:
    ctypes.string_at(0)


def native_hang() -> None:
    """Hold the interpreter's lock in native code, deaf to every signal but SIGKILL."""
    signal.pthread_sigmask(signal.SIG_BLOCK, set(signal.Signals) - {signal.SIGKILL, signal.SIGSTOP})
    ctypes.PyDLL(None).sleep(60)


def announced_hang() -> None:
    """Write this process's number to the file HANG_LOG before that."""
    Path(os.environ["HANG_LOG"]).write_text(str(os.getpid()))
    native_hang()


def abort() -> None:
    os.abort()


def leave() -> None:
    os._exit(7)


def eat_memory() -> None:
    held = []
    while True:
        held.append(bytearray(os.urandom(1) * 2**24))  # 16 MiB, touched
        time.sleep(1e-3)


def reserve(size: int, keep: bool) -> int:
    """Reserve bytes of address space, untouched; forget them unless they are to be kept."""
    block = np.empty(size, np.uint8)
    if keep:
        _blocks.append(block)
    return len(block)


def reserve_for_record(size: int) -> SimpleNamespace:
    """Reserve bytes; a failure is a record's status, as of a run."""
    try:
        return SimpleNamespace(record=SimpleNamespace(status="success", steps=reserve(size, keep=False)))
    except MemoryError:
        return SimpleNamespace(record=SimpleNamespace(status="out-of-memory", steps=0))
