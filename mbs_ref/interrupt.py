"""Ctrl-C is heard between steps, so that an interrupted run keeps what it computed."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from mbs_ref.integrators.leg import COUNT_INTERRUPTED, Progress


@contextmanager
def heard(run: Progress) -> Iterator[None]:
    """Let the first Ctrl-C ask the run to stop at its next look; a second one raises KeyboardInterrupt at once.

    Elsewhere than in the main thread, and where the program around handles the signal itself, nothing changes.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return

    def ask(number: int, frame: Any) -> None:
        if run.counts[COUNT_INTERRUPTED]:
            signal.default_int_handler(number, frame)
        run.counts[COUNT_INTERRUPTED] = 1

    signal.signal(signal.SIGINT, ask)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
