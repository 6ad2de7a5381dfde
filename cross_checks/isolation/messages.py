"""Messages between a caller and its child process, notes on the child's compiling, and how long a caller waits.

A caller waits for the time that the child computes or sleeps, not for the time that it waits for a processor: load on
the machine changes no verdict. Where the system does not report the time computed, the wall clock counts. Messages are
pickled whole, as bytes: Connection.send and recv pickle through a buffer that CPython may free in the wrong order
where Ctrl-C arrives in the middle of them; the process then ends in a segmentation fault.
"""

import os
import pickle
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
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


COMPILATION = 600.0  # s more that the compilation of a call may take
ASLEEP = frozenset("ST")  # states of a process that wants no processor; others run, wait for one, or for a disk


@dataclass(frozen=True)
class Moment:
    """What the clocks say of a process."""

    wall: float  # s
    computed: float | None  # s of processor time; None where the system does not tell
    asleep: bool = False


def moment(pid: int) -> Moment:
    """Read the clocks of a process."""
    wall = time.monotonic()
    try:
        state, *rest = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        ticks = int(rest[10]) + int(rest[11])  # proc(5): utime and stime, fields 14 and 15
    except (OSError, IndexError, ValueError):
        return Moment(wall, None)
    return Moment(wall, ticks / os.sysconf("SC_CLK_TCK"), state in ASLEEP)


def spent(before: Moment, now: Moment) -> float:
    """Return the time (s) that a process computed between two moments; all of it where it sleeps or none is known."""
    if before.computed is None or now.computed is None or (before.asleep and now.asleep):
        return now.wall - before.wall
    return now.computed - before.computed


class Patience:
    """The remaining time of a call (s), counted separately for the call and for its compilation."""

    def __init__(self, timeout: float, start: Moment, compilation: float | None = None) -> None:
        compilation = COMPILATION if compilation is None else compilation
        self._limits = self._left, self._compilation = timeout, compilation
        self._compiling, self._seen, self.used = False, start, 0.0

    def spend(self, now: Moment, note: str | None = None) -> str:
        """Spend the time since the last look; return what to complain of, or nothing. A note changes what comes."""
        used, self._seen = spent(self._seen, now), now
        self.used += used
        if self._compiling:
            self._compilation -= used
        else:
            self._left -= used
        self._compiling = note == COMPILING if note else self._compiling
        if self._left < 0.0:
            return f"gave no answer within {self._limits[0]:.4g} s"
        return f"compiled for more than {self._limits[1]:g} s" if self._compilation < 0.0 else ""
