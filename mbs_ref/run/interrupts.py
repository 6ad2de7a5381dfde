"""Ctrl-C that keeps what was computed: compiled loops cannot be interrupted, but they can run out of steps."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any, Self

from mbs_ref.integrators.loop.leg import Progress


class Interrupts:
    """While entered, the first SIGINT uses up the run's steps, so that its loop ends and leaves its states behind.

    Python hears the signal between two chunks of a compiled loop. A second SIGINT is a KeyboardInterrupt as ever.
    Where Ctrl-C is somebody else's business, and in other threads than the main one, nothing is changed.
    """

    def __init__(self, run: Progress, max_steps: int) -> None:
        self.asked = False
        self._run, self._max_steps, self._taken = run, max_steps, 0
        self._previous: Any = None

    @property
    def steps(self) -> int:
        """Steps truly taken."""
        count = int(self._run.steps)
        return self._taken + count - self._max_steps if self.asked else count

    def __enter__(self) -> Self:
        ours = threading.current_thread() is threading.main_thread()
        if ours and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            self._previous = signal.signal(signal.SIGINT, self._hear)
        return self

    def __exit__(self, *_: object) -> None:
        if self._previous is not None:
            signal.signal(signal.SIGINT, self._previous)

    def _hear(self, _number: int, _frame: FrameType | None) -> None:
        self.asked, self._taken = True, int(self._run.steps)
        self._run.steps = self._max_steps
        signal.signal(signal.SIGINT, self._previous)
