"""Say when Numba compiles: a call that compiles is not a call that hangs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.event import Event, Listener, install_listener


class _Teller(Listener):
    """Compiling a function compiles those that it calls: the outermost alone is told."""

    def __init__(self, begins: Callable[[], None], ends: Callable[[], None]) -> None:
        self._begins, self._ends, self._depth = begins, ends, 0

    def on_start(self, event: Event) -> None:
        if self._depth == 0:
            self._begins()
        self._depth += 1

    def on_end(self, event: Event) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._ends()


@contextmanager
def told(begins: Callable[[], None], ends: Callable[[], None]) -> Iterator[None]:
    """Within it, call `begins` before something is compiled that is in no cache, and `ends` after."""
    with install_listener("numba:compile", _Teller(begins, ends)):
        yield
