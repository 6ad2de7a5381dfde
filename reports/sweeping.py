"""Run a sweep with a bar; its runs lie in the store, so that an interrupted sweep goes on where it stopped."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import click

from cross_checks.records import lines
from cross_checks.records.lines import key_of
from cross_checks.records.record import Record
from mbs_ref.scene import Scene
from reports import inputs
from reports.terminal.asking import asked_runs
from reports.terminal.console import finite_record, progress
from reports.terminal.exit_codes import Failed, Incomplete


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
) -> list[Record]:
    """Return the sweep's records, and add to `target` those that it lacks; Incomplete where it is interrupted.

    Engines run in a process of their own, within `timeout` (s) and `memory_mib` for each run.
    """
    from benchmarks.sweep import DECADES, sweep

    names = inputs.engine_names(chosen)
    records: list[Record] = []
    with ExitStack() as stack:
        report = stack.enter_context(progress(f"sweep {scene.name}"))
        runs = stack.enter_context(asked_runs([scene], store, timeout, memory_mib))
        written = {key_of(record) for record in begun(stack, target)}
        try:
            for record in sweep(runs, scene, names, list(methods) or None, report, errors or DECADES):
                records.append(record)
                if target is not None and key_of(record) not in written:
                    lines.append(target, [finite_record(record)])
        except ValueError as error:  # a method that none of the engines offers
            raise click.UsageError(str(error)) from error
        except KeyboardInterrupt:
            raise Incomplete(f"interrupted after {len(records)} records") from None
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
