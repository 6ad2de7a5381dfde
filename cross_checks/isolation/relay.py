"""What a child says of its compiling, told to whoever waits for this process, which is a child of theirs then."""

from __future__ import annotations

import sys
from typing import Self

from cross_checks.isolation.messages import COMPILING


class Relay:
    """Passes notes on as Numba tells of its own compiling; what began has ended once the call is over."""

    def __init__(self) -> None:
        self._open = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._tell(False)

    def hear(self, note: str | None) -> None:
        """Pass a note on; None is no note."""
        if note is not None:
            self._tell(note == COMPILING)

    def _tell(self, begins: bool) -> None:
        events = sys.modules.get("numba.core.event")  # without it nobody listens here
        if events is not None and begins != self._open:
            (events.start_event if begins else events.end_event)("numba:compile")
            self._open = begins
