"""Calls in a process of their own: an engine that hangs, crashes or eats memory costs that one call."""

import math
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Self

from cross_checks.isolation.messages import NOTES, Patience, Relay, moment, receive, send

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
ONE_THREAD = dict.fromkeys(THREADS, "1")
TIMEOUT = 120.0  # s for one call, of which it computes or sleeps
MEMORY = 4 * 2**30  # bytes of resident memory
LOOK = 0.05  # s between looks at the child
PAGE = 4096 if sys.platform == "win32" else os.sysconf("SC_PAGE_SIZE")  # bytes
ABORTED = frozenset({signal.SIGABRT, signal.SIGKILL, signal.SIGSEGV})  # how native code ends without memory
NEARLY = 0.8  # of the memory limit: an abort beyond is blamed on memory

Caller = Callable[..., Any]  # (function, *arguments) -> what the function returns


class Lost(RuntimeError):
    """The call did not come back: `status` is timeout, crashed or out-of-memory."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status = status


class Cancelled(RuntimeError):
    """The call was given up by `cancel`, from another thread."""


def direct(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call in this process: for tests, and where the caller is isolated already."""
    return function(*arguments)


@dataclass
class Isolated:
    """A child process that makes calls one after the other, and is replaced when it is lost.

    Functions and arguments are pickled, so they must be importable by name. Limits hold for each call:
    `timeout` in s that the call computes or sleeps, without what Numba compiles, and `memory` in bytes. Libraries may
    use `threads`. `python` is the interpreter; another than ours takes `variables` (name, value) in place of our search
    path. `apart` makes a call in a copy of the child: what the child has loaded survives a call that does not. A child
    that has threads cannot be copied, and makes the call itself. A call that runs out of memory is repeated in a new
    child where this one has executed others, so that it depends on none of them. Use as a context manager.
    """

    timeout: float = TIMEOUT
    memory: int = MEMORY
    threads: int = 1
    python: str = sys.executable
    variables: tuple[tuple[str, str], ...] = ()
    _child: subprocess.Popen[bytes] | None = None
    _pipe: Connection | None = None
    _copy: int | None = None  # process id of the child's copy that makes the call
    _patience: Patience | None = None  # with the last call
    is_cancelled: bool = False
    _starting: threading.Lock = field(default_factory=threading.Lock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __call__(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return the function's result; Lost where there is none; its own exception where it raised one."""
        return self._call(function, arguments, apart=False)

    def expect(self, seconds: float) -> None:
        """Raise Lost in place of a call that is expected to compute for longer (s) than it may."""
        if seconds > self.timeout:
            share = f"about {seconds:.3g} s of {self.timeout:.4g} s at most"
            raise Lost("timeout", f"would take {share}, and was not begun")

    def patient(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call without a limit on time: for our own code, which comes back however busy the machine is."""
        return self._call(function, arguments, apart=False, timeout=math.inf)

    def apart(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call in a copy of the child, if it has one thread; where the copy is lost, the child itself stays."""
        return self._call(function, arguments, apart=True)

    def _call(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], apart: bool, timeout: float | None = None
    ) -> Any:
        has_served = not self.fresh
        worked, answer = self._attempt(function, arguments, apart, timeout or self.timeout)
        status = getattr(getattr(answer, "record", answer), "status", "")  # of a record that states it
        if isinstance(answer, MemoryError) or status == "out-of-memory":
            self.close()  # what it holds would be missing in later calls
            if has_served:  # earlier calls may hold the memory that this one lacked
                return self._call(function, arguments, apart, timeout)
        if not worked:
            raise answer
        return answer

    def _attempt(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], apart: bool, timeout: float
    ) -> tuple[bool, Any]:
        if self.fresh:
            self._start()
        assert self._pipe is not None
        try:
            send(self._pipe, (function, arguments, apart))
            with Relay() as relay:
                return self._answer(apart, timeout, relay)
        except (Lost, OSError) as error:
            if self.is_cancelled:
                raise Cancelled("the call was given up") from error
            return False, error

    @property
    def fresh(self) -> bool:
        """Whether the next call starts a new child."""
        return self._child is None or self._child.poll() is not None

    @property
    def used(self) -> float:
        """The time (s) that the last call computed or slept; infinite where it is unknown."""
        return math.inf if self._patience is None else self._patience.used

    @property
    def processors(self) -> int:
        """The number of parallel calls: the processors that this process may use."""
        return len(os.sched_getaffinity(0))

    def here(self) -> "Isolated":
        """Return a caller of the same limits on this machine."""
        return self

    def alike(self) -> "Isolated":
        """Return another caller of the same limits, with a child of its own."""
        return Isolated(self.timeout, self.memory, self.threads, self.python, self.variables)

    def close(self) -> None:
        """End the child, whatever it is doing."""
        self._end_copy()
        if self._child is not None:
            self._child.kill()
            self._child.wait()
        if self._pipe is not None:
            self._pipe.close()
        self._child = self._pipe = None

    def cancel(self) -> None:
        """End the child from another thread than the caller's: its call, and any later one, raises Cancelled.

        The pipe stays the caller's to close.
        """
        with self._starting:
            self.is_cancelled = True
            self._end_copy()
            if self._child is not None:
                self._child.kill()

    def _start(self) -> None:
        self.close()
        with self._starting:
            if self.is_cancelled:
                raise Cancelled("the calls were given up")
            self._launch()

    def _launch(self) -> None:
        ours, theirs = socket.socketpair()
        with ours, theirs:
            command = [self.python, "-m", "cross_checks.isolation.child", str(theirs.fileno()), str(self.memory)]
            paths = os.pathsep.join(path or os.getcwd() for path in sys.path)
            threads = dict.fromkeys(THREADS, str(self.threads))
            around = {"PYTHONPATH": paths} | dict(self.variables)
            self._child = subprocess.Popen(
                command, env=os.environ | threads | around, pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            self._pipe = Connection(ours.detach())

    def _answer(self, apart: bool, timeout: float, relay: Relay) -> tuple[bool, Any]:
        assert self._child is not None
        assert self._pipe is not None
        peak = 0
        try:
            self._copy = receive(self._pipe) if apart else None
            patience = self._patience = Patience(timeout, moment(self._copy or self._child.pid))
            while (message := receive(self._pipe) if self._pipe.poll(LOOK) else None) in (None, *NOTES):
                relay.receive(message)
                used = resident(self._copy or self._child.pid)
                peak = max(peak, used)
                if used > self.memory:
                    self._give_up()
                    raise Lost("out-of-memory", f"used more than {self.memory / 2**20:.0f} MiB and was stopped")
                complaint = patience.spend(moment(self._copy or self._child.pid), message)
                if complaint:
                    self._give_up()
                    raise Lost("timeout", f"{complaint} and was stopped")
        except (EOFError, ConnectionError):
            code = self._child.wait()
            self.close()
            raise _loss(code, peak, self.memory) from None
        self._copy = None
        worked, answer = message
        if worked is None:
            raise _loss(answer, peak, self.memory)
        return worked, answer

    def _give_up(self) -> None:
        """End the process of the call: the child, or its copy, whose end the child then reports."""
        if self._copy is None:
            self.close()
            return
        assert self._pipe is not None
        self._end_copy()
        while receive(self._pipe) in NOTES:
            pass

    def _end_copy(self) -> None:
        if self._copy is not None:
            with suppress(ProcessLookupError):
                os.kill(self._copy, signal.SIGKILL)
        self._copy = None


def resident(pid: int) -> int:
    """Return a process's resident memory in bytes; 0 where the system does not tell."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * PAGE
    except (OSError, IndexError):
        return 0


def _loss(code: int, peak: int, memory: int) -> Lost:
    if code >= 0:
        return Lost("crashed", f"its process ended with exit code {code}")
    name = signal.Signals(-code).name
    if -code in ABORTED and peak > NEARLY * memory:
        return Lost("out-of-memory", f"its process was ended by {name} at {peak / 2**20:.0f} MiB")
    return Lost("crashed", f"its process was ended by {name}")
