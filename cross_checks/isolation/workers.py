"""Tasks side by side in several processes of their own, results as they come; Ctrl-C ends them all."""

import atexit
import heapq
import math
import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from typing import Any, Self

from cross_checks.isolation.parent import MEMORY, Caller, Cancelled, Isolated, Lost

TIMEOUT = 300.0  # s for one call; the search bounds its work by steps, so that only a run that hangs meets this
BRIEF = 10.0  # s that a call of a task's first try may compute: longer than nearly all runs, short enough to wait for
LONGER = 4.0  # by which a second try's call may compute longer ...
LAST = 2  # ... and tries after which one has the whole time
FIRST = -1  # of a task that has the whole time at once, before all others
TICK = 1.0  # s between reports while no task ends

Report = Callable[[int, int, str], None]  # done, of how many, what is under way


class Late(RuntimeError):
    """A call of a task's first or second try computed longer than it may."""


class Over(Late):
    """A call would compute, or computed, for longer than it may at most, in a pool whose time is limited."""


@dataclass(order=True)
class _Task:
    place: tuple[int, float, int]  # by tries before this one, then the expected seconds, then first come
    name: Any = field(compare=False)
    work: Callable[[Caller], Any] = field(compare=False)


@dataclass
class _Worker:
    """What makes the calls of one task after the other."""

    call: Isolated
    timeout: float  # s, the whole time of a call
    brief: float  # s, of a first try's
    until: float  # s on the monotonic clock; later where calls have waited for a processor
    task: _Task | None = None
    since: float = 0.0  # s on the monotonic clock

    @property
    def patient(self) -> Caller:
        """What makes calls without a limit on time."""
        return self.call.patient

    def expect(self, seconds: float) -> None:
        """Raise Late, Over or Lost in place of a call that is expected to compute for longer (s) than it may."""
        self._tried(self.call.expect, seconds)

    def __call__(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return self._tried(self.call, function, *arguments)

    def _tried(self, call: Callable[..., Any], *arguments: Any) -> Any:
        tries, left = self.task.place[0] if self.task else LAST, self.until - time.monotonic()
        limit = min(LONGER**tries * self.brief, self.timeout) if 0 <= tries < LAST else self.timeout
        self.call.timeout = max(0.0, min(limit, left))
        if call is self.call and left <= 0.0:
            raise Over("no time is left for another run")
        begun = time.monotonic()
        try:
            return call(*arguments)
        except Lost as lost:
            if lost.status != "timeout" or left >= limit >= self.timeout:
                raise lost from None
            raise (Late if limit < min(self.timeout, left) else Over)(str(lost)) from None
        finally:
            self.until += max(0.0, time.monotonic() - begun - self.call.used) if call is self.call else 0.0


class Pool[Name, Result]:
    """Run tasks in parallel; tasks may be added or dropped while results arrive.

    Iterate to receive every task's name with what its work returns, in the order in which they end; an exception of
    the work is raised there. Tasks of fewest expected seconds begin first. Callers alike `call` execute the calls, one
    for each of its processors unless `workers` says how many. With `brief` (s) the calls of a first try stay within
    that, and of a second one within LONGER times that; the result of a task with one that does not is a Late. With
    `time_left` (s, from now, without what calls wait for a processor) the result is an Over of a task with a call for
    which that, or the whole time of a call, does not suffice. A `call` that is not Isolated makes every task in the
    caller's thread, and knows no limit. `tick` receives the tasks under way and their seconds. Use as a context
    manager.
    """

    def __init__(
        self, call: Caller, workers: int = 0, brief: float = math.inf, time_left: float = math.inf,
        tick: Callable[[list[tuple[Name, float]]], None] = lambda running: None,
    ) -> None:  # fmt: skip
        self._call, self._most, self._brief, self._until = call, workers, brief, time.monotonic() + time_left
        if isinstance(call, Isolated):
            self._most = workers or call.processors
        self._tick, self._numbers, self._closed = tick, count(), False
        self._waiting: list[_Task] = []  # a heap
        self._open: dict[int, _Task] = {}  # whose results nobody has received, by number
        self._done: queue.Queue[tuple[_Task, Any]] = queue.Queue()
        self._threads: list[threading.Thread] = []
        self._running: dict[int, _Worker] = {}  # by the thread that it serves
        self._changed = threading.Condition()

    def __enter__(self) -> Self:
        atexit.register(self.close)  # of a generator that nobody closes, whose processes would outlive this one
        return self

    def __exit__(self, *_: object) -> None:
        atexit.unregister(self.close)
        self.close()

    def close(self) -> None:
        """End the processes, whatever they are doing."""
        with self._changed:
            self._closed = True
            for worker in self._running.values():
                worker.call.cancel()
            self._changed.notify_all()
        for thread in self._threads:
            thread.join()

    def add(self, name: Name, work: Callable[[Caller], Result], seconds: float = 0.0, tries: int = 0) -> None:
        """Add a task that is expected to take `seconds`, after those with fewer `tries` before."""
        task = _Task((tries, seconds, next(self._numbers)), name, work)
        with self._changed:
            self._open[task.place[-1]] = task
            heapq.heappush(self._waiting, task)
            self._changed.notify()
        if isinstance(self._call, Isolated) and len(self._threads) < min(self._most, len(self._open)):
            self._threads.append(threading.Thread(target=self._serve, daemon=True))
            self._threads[-1].start()

    def drop(self, unwanted: Callable[[Name], bool]) -> None:
        """Forget the tasks whose names are unwanted, those under way included."""
        with self._changed:
            self._open = {number: task for number, task in self._open.items() if not unwanted(task.name)}
            self._waiting = [task for task in self._waiting if task.place[-1] in self._open]
            heapq.heapify(self._waiting)
            for worker in self._running.values():
                if worker.task is not None and worker.task.place[-1] not in self._open:
                    worker.call.cancel()

    def running(self) -> list[tuple[Name, float]]:
        """Return the names of the tasks under way, and for how long they are, s."""
        now = time.monotonic()
        with self._changed:
            under_way = [(one.task, now - one.since) for one in self._running.values()]
            return [(task.name, seconds) for task, seconds in under_way if task and task.place[-1] in self._open]

    def __iter__(self) -> Iterator[tuple[Name, Result | Late]]:
        while self._open:
            self._tick(self.running())
            with suppress(queue.Empty):
                if self._threads:
                    task, result = self._done.get(timeout=TICK)
                else:
                    task = heapq.heappop(self._waiting)
                    result = task.work(self._call)
                if self._open.pop(task.place[-1], None) is None:
                    continue
                if isinstance(result, BaseException) and not isinstance(result, Late):
                    raise result
                yield task.name, result

    def _serve(self) -> None:
        """Execute tasks until the pool is closed; a process whose task was dropped is replaced."""
        while not self._closed:
            with self._call.alike() as call, suppress(Cancelled):  # type: ignore[attr-defined] - an Isolated has threads
                worker = _Worker(call, call.timeout, self._brief, self._until)
                while (task := self._next(worker)) is not None:
                    self._done.put((task, _made(worker, task)))

    def _next(self, worker: _Worker) -> _Task | None:
        """Return the next task, given to the worker; None where the pool is closed."""
        with self._changed:
            self._running.pop(threading.get_ident(), None)
            if worker.call.is_cancelled:
                raise Cancelled("its last task was dropped")
            self._changed.wait_for(lambda: self._waiting or self._closed)
            if self._closed:
                return None
            worker.task, worker.since = heapq.heappop(self._waiting), time.monotonic()
            self._running[threading.get_ident()] = worker
            return worker.task


def _made(worker: _Worker, task: _Task) -> Any:
    try:
        return task.work(worker)
    except Cancelled:
        raise
    except BaseException as error:  # raised again in the caller's thread
        return error


def each[Task, Result](
    tasks: Sequence[Task], work: Callable[[Caller, Task], Result], workers: int = 0, timeout: float = TIMEOUT,
    memory: int = MEMORY, call: Isolated | None = None,
) -> Iterator[tuple[Task, Result]]:  # fmt: skip
    """Yield every task with what `work` returns for it, as soon as it is known, from a Pool without first tries.

    Callers alike `call` execute the calls, processes of this machine unless given.
    """
    with Pool[Task, Result](call or Isolated(timeout, memory), workers) as pool:
        for task in tasks:
            pool.add(task, lambda call, task=task: work(call, task))
        yield from pool  # type: ignore[misc]
