"""Tasks given to several processes of their own, results as they come; Ctrl-C ends them all."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

from cross_checks.isolation.parent import MEMORY, Caller, Cancelled, Isolated

TIMEOUT = 300.0  # s for one call; the search bounds its work by steps, so that only a run that hangs meets this


def each[Task, Result](
    tasks: Sequence[Task], work: Callable[[Caller, Task], Result], workers: int = 0, timeout: float = TIMEOUT,
    memory: int = MEMORY,
) -> Iterator[tuple[Task, Result]]:  # fmt: skip
    """Yield every task with what `work` returns for it, as soon as it is known; its exception is raised here.

    Each worker has one thread; unless given, there is one for every processor that this process may use. Each of their
    calls is made within `timeout` (s) and `memory` (bytes).
    """
    waiting: queue.Queue[Task] = queue.Queue()
    done: queue.Queue[tuple[Task, Result] | BaseException] = queue.Queue()
    for task in tasks:
        waiting.put(task)
    calls = [Isolated(timeout, memory) for _ in range(min(workers or len(os.sched_getaffinity(0)), len(tasks)))]
    threads = [threading.Thread(target=_serve, args=(waiting, done, work, call)) for call in calls]
    for thread in threads:
        thread.start()
    try:
        for _ in tasks:
            found = done.get()
            if isinstance(found, BaseException):
                raise found
            yield found
    finally:
        _empty(waiting)
        for call in calls:
            call.cancel()
        for thread in threads:
            thread.join()


def _serve(waiting: queue.Queue, done: queue.Queue, work: Callable, call: Isolated) -> None:
    with call, suppress(queue.Empty, Cancelled):
        while True:
            task = waiting.get_nowait()
            try:
                done.put((task, work(call, task)))
            except Cancelled:
                return
            except BaseException as error:  # told to the caller's thread
                done.put(error)
                return


def _empty(waiting: queue.Queue) -> None:
    with suppress(queue.Empty):
        while True:
            waiting.get_nowait()
