"""mbs-ref matrix: the accuracy matrix, over processes or a cluster."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from cross_checks.records.record import Record
from cross_checks.records.store import Run
from reports import inputs
from reports.terminal.asking import STORE, asked_runs
from reports.terminal.console import echo_json, number, progress, show, table
from reports.terminal.exit_codes import Failed, Incomplete, NothingSelected

if TYPE_CHECKING:
    from benchmarks.cluster import Task


@click.command(name="matrix")
@inputs.ENGINES
@click.option("--quick", is_flag=True, help="Three scenes, the coarsest settings.")
@click.option("--serial", is_flag=True, help="One run after the other, without dask.")
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="A dask scheduler; a local cluster unless given.")
@click.option("--workers", type=click.IntRange(1), help="Processes of the local cluster; one a processor unless given.")
@click.option("--shard", metavar="I/N", default="1/1", help="Only part I of N, for batch systems.")
@click.option("--timeout", type=float, default=120.0, show_default=True, help="Longest time a run computes, s.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines, one a run.")
@STORE
def command(
    chosen: tuple[str, ...], quick: bool, serial: bool, scheduler: str | None, workers: int | None, shard: str,
    timeout: float, as_json: bool, store: str | None,
) -> None:  # fmt: skip
    """Judge every engine, method and setting on the default scenes; accuracy only, nothing is timed alone.

    Runs are the same however they are spread: lost workers, shards and interruptions cost nothing but time. Shards
    keep their runs in stores of their own, which `mbs-ref merge` joins.
    """
    from benchmarks import cluster

    tasks = inputs.shard(cluster.plan(quick, inputs.engine_names(chosen)), shard)
    if not tasks:
        raise NothingSelected("no runs in this part of the matrix")
    found: dict[Task, Record] = {}
    with asked_runs([], store) as runs, progress("matrix") as report:
        held = {task: cluster.held(runs, task) for task in tasks}
        found = {task: record for task, record in held.items() if record is not None}
        try:
            for task, run in _spread([t for t in tasks if t not in found], serial, timeout, scheduler, workers):
                found[task] = cluster.kept(runs, task, run)
                report(len(found), len(tasks), f"{task.scene} {task.engine}")
        except KeyboardInterrupt:
            raise Incomplete(f"interrupted after {len(found)} of {len(tasks)} runs") from None
    _show([found[task] for task in tasks], as_json)


def _show(records: list[Record], as_json: bool) -> None:
    for record in records if as_json else ():
        echo_json(record.to_dict(), indent=None)
    if as_json:
        return
    listing = table("", "scene", "engine", "method", "status", "error", "task, s")
    for r in records:
        figures = (number(r.error.value if r.error else None), number(r.times.get("task_s")))
        listing.add_row(r.scene, r.engine, r.method, r.status, *figures)
    show(listing)


def _spread(
    tasks: list[Task], serial: bool, timeout: float, scheduler: str | None, workers: int | None
) -> Iterator[tuple[Task, Run]]:
    from benchmarks import cluster

    if not tasks:
        return iter(())
    if serial:
        return cluster.serial(tasks, timeout)
    try:
        from benchmarks.dask_matrix import distributed
    except ModuleNotFoundError as error:
        if error.name != "distributed":
            raise
        advice = "the package distributed is not installed (pip install mbs-ref[cluster]); or use --serial"
        raise Failed(advice) from error
    return distributed(tasks, timeout, scheduler, workers)
