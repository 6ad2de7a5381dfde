"""How long a caller waits: in time that the child computes or sleeps, not in time that it waits for a processor.

A machine that others load makes a run last longer and its verdict no other. Where the system does not tell what a
process has computed, the wall clock counts.
"""

import os
import time
from dataclasses import dataclass
from pathlib import Path

from cross_checks.isolation.messages import COMPILING

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
    """Return the time that a process computed between two moments, s; all of it where it sleeps or none is told."""
    if before.computed is None or now.computed is None or (before.asleep and now.asleep):
        return now.wall - before.wall
    return now.computed - before.computed


class Patience:
    """What is left of a call's time; it is spent on the call or on its compilation."""

    def __init__(self, timeout: float, start: Moment, compilation: float | None = None) -> None:
        compilation = COMPILATION if compilation is None else compilation
        self._limits = self._left, self._compilation = timeout, compilation
        self._compiling, self._seen = False, start

    def spend(self, now: Moment, note: str | None = None) -> str:
        """Spend the time since the last look; return what to complain of, or nothing. A note changes what comes."""
        used, self._seen = spent(self._seen, now), now
        if self._compiling:
            self._compilation -= used
        else:
            self._left -= used
        self._compiling = note == COMPILING if note else self._compiling
        if self._left < 0.0:
            return f"gave no answer within {self._limits[0]:g} s"
        return f"compiled for more than {self._limits[1]:g} s" if self._compilation < 0.0 else ""
