"""The other end of cross_checks.isolation.parent: receive a call, make it, send back what came of it."""

import ctypes
import os
import resource
import select
import signal
import sys
from contextlib import suppress
from multiprocessing.connection import Connection, Pipe
from typing import Any

from cross_checks.isolation.messages import COMPILED, COMPILING, NOTES, compiling_reported, receive, send

STOPS = [signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if name in signal.Signals.__members__]
SET_PARENT_DEATH_SIGNAL = 1  # prctl(2)
ROOM = 4 * 2**30  # bytes of address space beyond the limit on resident memory: libraries reserve much, use little


def serve(pipe: Connection) -> None:
    """Answer calls until the caller goes away."""
    while True:
        try:
            function, arguments, apart = receive(pipe)
        except (EOFError, ConnectionError):
            return
        if apart and _has_one_thread():
            _copied(pipe, function, arguments)
        else:
            if apart:
                send(pipe, None)  # in place of the copy's id: the call is executed here
            send(pipe, _answer(pipe, function, arguments))


def _has_one_thread() -> bool:
    """Whether this process may be copied: in a copy other threads, as XLA's, are gone, and what they held is locked."""
    try:
        return len(os.listdir("/proc/self/task")) == 1
    except OSError:  # a system that does not tell
        return True


def _copied(pipe: Connection, function: Any, arguments: tuple[Any, ...]) -> None:
    """Execute the call in a copy of this process: send its id, its notes, its answer, or (None, exit code).

    The copy sends through a pipe of its own, so that one ended while it sends leaves no partial message.
    """
    here, there = Pipe(duplex=False)
    copy = os.fork()
    if copy == 0:
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)
        pipe.close()  # its end of the file must come when the original goes
        send(there, _answer(there, function, arguments))
        os._exit(0)
    there.close()
    send(pipe, copy)
    try:
        while (answer := receive(here)) in NOTES:
            send(pipe, answer)
    except (EOFError, OSError):
        answer = None
    here.close()
    _, status = os.waitpid(copy, 0)
    send(pipe, answer or (None, os.waitstatus_to_exitcode(status)))


def _answer(pipe: Connection, function: Any, arguments: tuple[Any, ...]) -> tuple[bool, Any]:
    try:
        with compiling_reported(lambda: send(pipe, COMPILING), lambda: send(pipe, COMPILED)):
            return True, function(*arguments)
    except Exception as error:  # raised again where the call came from
        return False, error


def end_with_caller(handle: int) -> None:
    """Let a small process end this one once the caller is gone, even by SIGKILL: a native loop runs no handler."""
    if sys.platform != "linux":
        return
    try:
        caller, own = os.pidfd_open(os.getppid()), os.pidfd_open(os.getpid())
    except OSError:  # before Linux 5.3
        return
    if os.fork() == 0:
        os.close(handle)  # its end of the file must come when this process goes
        select.select([caller, own], [], [])
        with suppress(ProcessLookupError):
            signal.pidfd_send_signal(own, signal.SIGKILL)
        os._exit(0)
    os.close(caller)
    os.close(own)


def main() -> None:
    for stop in STOPS:  # are the caller's to handle; it ends this process
        signal.signal(stop, signal.SIG_IGN)
    handle, memory = int(sys.argv[1]), int(sys.argv[2])
    end_with_caller(handle)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    most = memory + ROOM
    resource.setrlimit(resource.RLIMIT_AS, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    serve(Connection(handle))


if __name__ == "__main__":
    main()
