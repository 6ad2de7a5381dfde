"""The matrix on dask.distributed: an optional package, imported here alone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from distributed import Client, LocalCluster, as_completed
from distributed.worker import get_worker

from benchmarks.cluster import RETRIES, Task, isolated_task
from cross_checks.isolation.parent import Isolated
from cross_checks.records.store import Run

NOWHERE: str = None  # type: ignore[assignment] - distributed's own way to have no dashboard


def distributed(
    tasks: Iterable[Task], timeout: float, scheduler: str | None = None, workers: int | None = None
) -> Iterator[tuple[Task, Run]]:
    """Yield runs as they come, from the cluster at `scheduler`, or from a local one of `workers` processes."""
    if scheduler is not None:
        with Client(scheduler) as client:
            yield from gather(client, tasks, timeout)
        return
    local = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=NOWHERE)
    with local as cluster, Client(cluster) as client:
        yield from gather(client, tasks, timeout)


def gather(client: Client, tasks: Iterable[Task], timeout: float) -> Iterator[tuple[Task, Run]]:
    """Yield runs as they come; a task whose worker is lost runs again on another."""
    futures = client.map(_on_worker, list(tasks), timeout=timeout, retries=RETRIES, pure=False)
    for future in as_completed(futures):
        yield future.result()
        future.release()  # a worker that is lost later need not make it again


def _on_worker(task: Task, timeout: float) -> tuple[Task, Run]:
    """Run in a process beside the worker, so that a crash of an engine does not end the worker."""
    worker = get_worker()
    call = _CALLS.get(worker.id)
    if call is None:
        call = _CALLS[worker.id] = Isolated(timeout=timeout)
    return task, isolated_task(task, call)


_CALLS: dict[str, Isolated] = {}  # one child process a worker, kept from task to task
