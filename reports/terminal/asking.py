"""The store that commands ask, and the process that makes the runs which it lacks."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import click

from cross_checks.isolation.child import STOPS
from cross_checks.isolation.parent import MEMORY, TIMEOUT, Isolated, direct
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store, default_path
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import python_parts
from reports.terminal.console import Report
from reports.terminal.exit_codes import Failed

FIRST = 20.0  # s until the best answer so far is printed; then again whenever that time has doubled

STORE = click.option(
    "--store", metavar="FILE.sqlite", help="The store of runs.  [default: MBS_REF_STORE, or one in the cache folder]"
)


def store_path(named: str | None) -> Path:
    """Return the file of the store: the one named, else the machine's."""
    return Path(named) if named else default_path()


@contextmanager
def asked_runs(
    scenes: Iterable[Scene], store: str | None = None, timeout: float | None = None, memory_mib: float | None = None,
    scheduler: str | None = None,
) -> Iterator[Runs]:  # fmt: skip
    """Open the store and a process for its runs, each within `timeout` (s) and `memory_mib`.

    A user's Python function cannot travel to another process: scenes that have one run in this process. A signal that
    ends the process raises KeyboardInterrupt meanwhile, as Ctrl-C does.
    """
    with stoppable(), Store(store_path(store)) as kept, isolated(scenes, timeout, memory_mib, scheduler) as call:
        yield Runs(kept, call)


def isolated(
    scenes: Iterable[Scene], timeout: float | None = None, memory_mib: float | None = None,
    scheduler: str | None = None,
):  # fmt: skip
    """Return what makes calls in a process of their own, where the scenes can travel there, or on a dask cluster.

    Failed where the package for clusters is not installed.
    """
    if any(python_parts(scene) for scene in scenes):
        return nullcontext(direct)
    limits = timeout or TIMEOUT, MEMORY if memory_mib is None else int(memory_mib * 2**20)
    if scheduler is None:
        return Isolated(*limits)
    try:
        from cross_checks.isolation.remote import Remote
    except ModuleNotFoundError as error:
        raise Failed(f"the package {error.name} is not installed (pip install mbs-ref[cluster])") from error
    return Remote(*limits, scheduler=scheduler)


@contextmanager
def stoppable() -> Iterator[None]:
    """Raise KeyboardInterrupt within it on SIGINT, SIGTERM, and SIGHUP unless that is ignored as by nohup."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {one: signal.getsignal(one) for one in STOPS}
    for one in STOPS:
        if one is not STOPS[-1] or before[one] is not signal.SIG_IGN:
            signal.signal(one, signal.default_int_handler)
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


def telling(report: Report, best: Callable[[], str]) -> Report:
    """Return a report that also prints the best answer so far on stderr: after FIRST s, then at twice that, and so on.

    Nothing where the answer is empty.
    """
    begun, due = time.monotonic(), FIRST

    def reported(done: int, total: int, what: str = "") -> None:
        nonlocal due
        report(done, total, what)
        if (passed := time.monotonic() - begun) >= due and (text := best()):
            due = 2.0 * passed
            click.echo(f"So far, after {passed:.0f} s: {text}", err=True)

    return reported
