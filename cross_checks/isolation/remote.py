"""Calls on the workers of a dask cluster: an optional package, imported here alone."""

import math
from collections.abc import Callable
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import Any

from distributed import Client, Future
from distributed.scheduler import KilledWorker
from distributed.worker import get_worker

from cross_checks.isolation.parent import Cancelled, Isolated, Lost

RETRIES = 5  # times a call may lose its worker
Answered = tuple[bool, Any]  # whether the call came back, and its result; else the arguments of Lost


@dataclass
class Remote(Isolated):
    """Calls as those of Isolated, each in a process beside a worker of the cluster, whose crash the worker survives.

    A call whose worker is lost is repeated on another.
    """

    scheduler: str = ""  # its address
    _client: Client | None = None  # shared with those alike
    _is_alike: bool = False  # whether another closes the connection
    _future: Future | None = None

    @property
    def client(self) -> Client:
        """The connection, opened at the first use."""
        if self._client is None:
            self._client = Client(self.scheduler)
        return self._client

    @property
    def processors(self) -> int:
        """How many calls the cluster can make side by side."""
        return max(1, sum(dict(self.client.nthreads()).values()))  # type: ignore[call-overload] - no coroutine

    def here(self) -> Isolated:
        """Return a caller of the same limits on this machine."""
        return Isolated(self.timeout, self.memory)

    def alike(self) -> "Remote":
        """Return another caller on the same cluster."""
        return Remote(self.timeout, self.memory, scheduler=self.scheduler, _client=self.client, _is_alike=True)

    def close(self) -> None:
        """Cancel the running call, and close the connection where this caller opened it."""
        if self._future is not None:
            self._future.cancel()
        if self._client is not None and not self._is_alike:
            self._client.close()

    def cancel(self) -> None:
        """Cancel the running call, from another thread, and every later one."""
        self.is_cancelled = True
        if self._future is not None:
            self._future.cancel()

    def _call(
        self, function: Callable[..., Any], arguments: tuple[Any, ...], apart: bool, timeout: float | None = None
    ) -> Any:
        if self.is_cancelled:
            raise Cancelled("the calls were given up")
        limits = timeout or self.timeout, self.memory
        self._future = self.client.submit(_made, function, arguments, *limits, retries=RETRIES, pure=False)
        try:
            came_back, answer = self._future.result()
        except CancelledError as error:
            raise Cancelled("the call was given up") from error
        except KilledWorker as error:
            raise Lost("crashed", f"every worker that made it was lost: {error}") from error
        if not came_back:
            raise Lost(*answer)
        return answer


def _made(function: Callable[..., Any], arguments: tuple[Any, ...], timeout: float, memory: int) -> Answered:
    """Execute the call in a process beside this worker, which later calls use again."""
    call = _CALLS.setdefault(get_worker().id, Isolated())
    call.timeout, call.memory = timeout, memory
    try:
        return True, call.patient(function, *arguments) if math.isinf(timeout) else call(function, *arguments)
    except Lost as lost:
        return False, (lost.status, str(lost))


_CALLS: dict[str, Isolated] = {}  # one child process a worker
