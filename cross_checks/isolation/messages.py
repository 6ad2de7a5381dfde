"""Messages between a caller and its child process, and notes on the child's compiling.

Messages are pickled whole, as bytes. Connection.send and recv pickle through a buffer that CPython may free in the
wrong order where Ctrl-C arrives in the middle of them; the process then ends in a segmentation fault.
"""

import pickle
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any, Self

NOTES = COMPILING, COMPILED = "compiling", "compiled"  # sent before an answer: a caller's patience rests between them


def send(pipe: Connection, message: Any) -> None:
    """Send a message; OSError where the other end is gone."""
    pipe.send_bytes(pickle.dumps(message))


def receive(pipe: Connection) -> Any:
    """Return the next message, waiting for it; EOFError or ConnectionError where the other end is gone."""
    return pickle.loads(pipe.recv_bytes())


@contextmanager
def compiling_reported(begins: Callable[[], None], ends: Callable[[], None]) -> Iterator[None]:
    """Call `begins` before something is compiled that is in no cache, and `ends` after; nested ones do not count."""
    from numba.core.event import Event, Listener, install_listener  # a slow import that callers do not need

    class Outermost(Listener):
        depth = 0

        def on_start(self, event: Event) -> None:
            self.depth += 1
            if self.depth == 1:
                begins()

        def on_end(self, event: Event) -> None:
            self.depth -= 1
            if self.depth == 0:
                ends()

    with install_listener("numba:compile", Outermost()):
        yield


class Relay:
    """Passes notes on as Numba reports its own compiling; what began has ended once the call is over."""

    def __init__(self) -> None:
        self._open = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._report(False)

    def receive(self, note: str | None) -> None:
        """Pass a note on; None is no note."""
        if note is not None:
            self._report(note == COMPILING)

    def _report(self, begins: bool) -> None:
        events = sys.modules.get("numba.core.event")  # not imported: there is no listener
        if events is not None and begins != self._open:
            (events.start_event if begins else events.end_event)("numba:compile")
            self._open = begins
