"""The other end of cross_checks.isolation: receive a call, make it, send back what came of it."""

from __future__ import annotations

import resource
import signal
import sys
from multiprocessing.connection import Connection
from typing import Any

ROOM = 4 * 2**30  # bytes of address space beyond the limit on resident memory: libraries reserve much, use little


def serve(pipe: Connection) -> None:
    """Answer calls until the caller goes away."""
    while True:
        try:
            function, arguments = pipe.recv()
        except (EOFError, ConnectionError):
            return
        pipe.send(_answer(function, arguments))


def _answer(function: Any, arguments: tuple[Any, ...]) -> tuple[bool, Any]:
    try:
        return True, function(*arguments)
    except Exception as error:  # raised again where the call came from
        return False, error


def main() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the caller's to handle; it ends this process
    handle, memory = int(sys.argv[1]), int(sys.argv[2])
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = memory + ROOM
    resource.setrlimit(resource.RLIMIT_AS, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    serve(Connection(handle))


if __name__ == "__main__":
    main()
