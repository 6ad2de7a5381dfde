"""Run a sweep with a bar; every record is on the disk as soon as it is known, and an interrupted sweep resumes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path

import click

from cross_checks import engines
from cross_checks.isolation.parent import MEMORY, TIMEOUT, Caller, Isolated, direct
from cross_checks.records import lines as record_file
from cross_checks.records.record import Record
from mbs_ref.scene import Scene, UserForce
from reports import inputs
from reports.console import finite_record, progress
from reports.exit_codes import Failed, Incomplete


def sweep_records(
    scene: Scene,
    chosen: tuple[str, ...],
    methods: tuple[str, ...],
    target: Path | None,
    timeout: float | None = None,
    memory_mib: float | None = None,
) -> list[Record]:
    """Return the sweep's records, those that `target` already holds included; Incomplete where it is interrupted.

    Engines run in a process of their own, within `timeout` (s) and `memory_mib` for each run.
    """
    from benchmarks import sweep

    for name in chosen:
        inputs.engine(name)
    with ExitStack() as stack:
        report = stack.enter_context(progress(f"sweep {scene.name}"))
        call = stack.enter_context(isolated(scene, timeout, memory_mib))
        records = begun(stack, target)
        try:
            names = list(chosen) or engines.names()
            fresh = sweep.sweep(scene, names, list(methods) or None, report, call=call, known=tuple(records))
            for record in _kept(fresh, target):
                records.append(record)
        except ValueError as error:  # a method that none of the engines offers
            raise click.UsageError(str(error)) from error
        except KeyboardInterrupt:
            raise Incomplete(f"interrupted after {len(records)} records") from None
    return records


def isolated(
    scene: Scene, timeout: float | None = None, memory_mib: float | None = None
) -> AbstractContextManager[Caller]:
    """Return what makes calls in a process of their own; a user's Python force cannot travel to another process."""
    if any(isinstance(load, UserForce) for load in scene.loads):
        return nullcontext(direct)
    memory = MEMORY if memory_mib is None else int(memory_mib * 2**20)
    return Isolated(timeout or TIMEOUT, memory)


def begun(stack: ExitStack, target: Path | None) -> list[Record]:
    """Return what interrupted work left in the file, and keep others from writing it."""
    if target is None:
        return []
    try:
        stack.enter_context(record_file.exclusive(target))
    except record_file.Busy as error:
        raise Failed(str(error)) from error
    records, problems = record_file.read(target)
    for problem in problems:
        click.echo(problem, err=True)
    if records:
        click.echo(f"{target} holds {len(records)} records already; what is missing is added", err=True)
    return records


def _kept(records: Iterator[Record], target: Path | None) -> Iterator[Record]:
    for record in records:
        if target is not None:
            record_file.append(target, [finite_record(record)])
        yield record
