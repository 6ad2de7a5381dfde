"""The store that commands ask, and the process that makes the runs which it lacks."""

import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cross_checks.isolation import workers
from cross_checks.isolation.child import STOPS
from cross_checks.isolation.parent import MEMORY, TIMEOUT, Isolated, direct
from cross_checks.judge.runs import Runs
from cross_checks.records import lines
from cross_checks.records.lines import key_of
from cross_checks.records.record import Record
from cross_checks.records.store import Store, default_path
from mbs_ref import Scene
from mbs_ref.scene.traits import python_parts
from reports import inputs
from reports.console import Failed, Incomplete, Report, complain, finite_record, progress, reported_as

FIRST = 20.0  # s until the best answer so far is printed; then again whenever that time has doubled

STORE = click.option(
    "--store", metavar="FILE.sqlite", help="The store of runs.  [default: MBS_REF_STORE, or one in the cache folder]"
)

SCHEDULER = click.option("--scheduler", metavar="tcp://HOST:PORT", help="Run on the workers of a dask cluster.")


def store_path(named: str | None) -> Path:
    """Return the file of the store: the one named, else the machine's."""
    return Path(named) if named else default_path()


@contextmanager
def open_runs(
    scenes: Iterable[Scene], store: str | None = None, timeout: float | None = None, memory_mib: float | None = None,
    scheduler: str | None = None,
) -> Iterator[Runs]:  # fmt: skip
    """Open the store and a process for its runs, each within `timeout` (s) and `memory_mib`.

    A user's Python function cannot travel to another process: scenes that have one run in this process. A signal that
    ends the process raises KeyboardInterrupt meanwhile, as Ctrl-C does.
    """
    with stoppable(), Store(store_path(store)) as stored, isolated(scenes, timeout, memory_mib, scheduler) as call:
        yield Runs(stored, call)


def isolated(
    scenes: Iterable[Scene], timeout: float | None = None, memory_mib: float | None = None, scheduler: str | None = None
):
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
def cluster(scheduler: str | None) -> Iterator[Isolated | None]:
    """Yield what makes calls on the workers of a dask cluster; None without one."""
    if scheduler is None:
        yield None
    else:
        with isolated((), workers.TIMEOUT, scheduler=scheduler) as call:
            yield call  # type: ignore[misc] - no scene has a Python function


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


def reporting(report: Report, best: Callable[[], str]) -> Report:
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


if TYPE_CHECKING:
    from cross_checks.prices.sweep import Worth


class Interrupted(Incomplete):
    """A sweep was cut short: the runs that it has, judged, not all of them timed alone."""

    def __init__(self, message: str, records: Sequence[Record]) -> None:
        super().__init__(message)
        self.records = records


def sweep_records(
    scene: Scene, chosen: tuple[str, ...], methods: tuple[str, ...], target: Path | None, timeout: float | None = None,
    memory_mib: float | None = None, *, store: str | None = None, scheduler: str | None = None,
    errors: tuple[float, ...] = (), best: Callable[[Sequence[Record]], str] = lambda records: "",
    worth: "Worth | None" = None,
) -> list[Record]:  # fmt: skip
    """Return the sweep's records, and add to `target` those that it lacks; Interrupted where it is cut short.

    Engines run in a process of their own, within `timeout` (s) and `memory_mib` for each run. `best` states what the
    runs so far show, which is printed while others run. `worth` returns the runs that are timed alone, all unless
    given.
    """
    from cross_checks.prices.sweep import DECADES, sweep

    names = inputs.engine_names(chosen)
    records: list[Record] = []
    so_far: list[Record] = []
    with ExitStack() as stack:
        report = reporting(stack.enter_context(progress(f"sweep {scene.name}")), lambda: best(so_far))
        runs = stack.enter_context(open_runs([scene], store, timeout, memory_mib, scheduler))
        written = {key_of(record) for record in begun(stack, target, lines.read)}
        try:
            for record in sweep(
                runs, scene, names, list(methods) or None, report, errors or DECADES,
                lambda judged: so_far.__setitem__(slice(None), judged), worth,
            ):  # fmt: skip
                records.append(record)
                if target is not None and key_of(record) not in written:
                    lines.append(target, [finite_record(record)])
        except ValueError as error:  # a method that none of the engines offers
            raise click.UsageError(str(error)) from error
        except KeyboardInterrupt:
            timed = {key_of(record): record for record in records}
            runs_so_far = [timed.get(key_of(record), record) for record in so_far]
            said = f"interrupted after {len(so_far)} runs, {len(records)} of them timed"
            raise Interrupted(said, runs_so_far) from None
    return records


def begun[Item](
    stack: ExitStack, target: Path | None, read: Callable[[Path], tuple[list[Item], list[str]]]
) -> list[Item]:
    """Return what a file holds, which others cannot write until the stack is closed; nothing without a file."""
    if target is None:
        return []
    with reported_as(Failed, lines.Busy):
        stack.enter_context(lines.exclusive(target))
    records, problems = read(target)
    complain(problems)
    if records:
        click.echo(f"{target} holds {len(records)} records already; what is missing is added", err=True)
    return records
