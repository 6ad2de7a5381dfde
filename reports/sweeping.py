"""Run a sweep with a bar; its runs lie in the store, so that an interrupted sweep goes on where it stopped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cross_checks.records import lines
from cross_checks.records.lines import key_of
from cross_checks.records.record import Record
from mbs_ref.scene import Scene
from reports import inputs
from reports.terminal.asking import asked_runs, telling
from reports.terminal.console import finite_record, progress
from reports.terminal.exit_codes import Failed, Incomplete

if TYPE_CHECKING:
    from benchmarks.sweep import Worth


class Interrupted(Incomplete):
    """A sweep was cut short: the runs that it has, judged, not all of them timed alone."""

    def __init__(self, message: str, records: Sequence[Record]) -> None:
        super().__init__(message)
        self.records = records


def sweep_records(
    scene: Scene,
    chosen: tuple[str, ...],
    methods: tuple[str, ...],
    target: Path | None,
    timeout: float | None = None,
    memory_mib: float | None = None,
    *,
    store: str | None = None,
    errors: tuple[float, ...] = (),
    best: Callable[[Sequence[Record]], str] = lambda records: "",
    worth: Worth | None = None,
) -> list[Record]:
    """Return the sweep's records, and add to `target` those that it lacks; Interrupted where it is cut short.

    Engines run in a process of their own, within `timeout` (s) and `memory_mib` for each run. `best` states what the
    runs so far show, which is printed while others are made. `worth` returns the runs that are timed alone, all unless
    given.
    """
    from benchmarks.sweep import DECADES, sweep

    names = inputs.engine_names(chosen)
    records: list[Record] = []
    so_far: list[Record] = []
    with ExitStack() as stack:
        report = telling(stack.enter_context(progress(f"sweep {scene.name}")), lambda: best(so_far))
        runs = stack.enter_context(asked_runs([scene], store, timeout, memory_mib))
        written = {key_of(record) for record in begun(stack, target)}
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
            so_far[: len(records)] = records  # those that are timed by now
            raise Interrupted(f"interrupted after {len(records)} of {len(so_far)} records", so_far) from None
    return records


def begun(stack: ExitStack, target: Path | None) -> list[Record]:
    """Return what interrupted work left in the file, and keep others from writing it."""
    if target is None:
        return []
    try:
        stack.enter_context(lines.exclusive(target))
    except lines.Busy as error:
        raise Failed(str(error)) from error
    records, problems = lines.read(target)
    for problem in problems:
        click.echo(problem, err=True)
    if records:
        click.echo(f"{target} holds {len(records)} records already; what is missing is added", err=True)
    return records
