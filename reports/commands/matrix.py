"""mbs-ref matrix: the accuracy matrix, over processes or a cluster."""

from __future__ import annotations

import re
from pathlib import Path

import click

from cross_checks import record_file
from reports import inputs
from reports.console import echo_json, finite_record, number, progress, show, table
from reports.exit_codes import Failed, Incomplete, NothingSelected


@click.command(name="matrix")
@click.option("--engine", "chosen", multiple=True, metavar="E", help="Only this engine; repeatable.")
@click.option("--quick", is_flag=True, help="Three scenes, the coarsest settings.")
@click.option("--serial", is_flag=True, help="One run after the other, without dask.")
@click.option("--scheduler", metavar="tcp://HOST:PORT", help="A dask scheduler; a local cluster unless given.")
@click.option("--workers", type=click.IntRange(1), help="Processes of the local cluster; one a processor unless given.")
@click.option("--shard", metavar="I/N", default="1/1", help="Only part I of N, for batch systems.")
@click.option("--timeout", type=float, default=120.0, show_default=True, help="Longest time of one run, s.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines, one a run.")
@click.option("-o", "output", metavar="FILE.jsonl", help="Add the lines to a file as they come.")
def command(
    chosen: tuple[str, ...],
    quick: bool,
    serial: bool,
    scheduler: str | None,
    workers: int | None,
    shard: str,
    timeout: float,
    as_json: bool,
    output: str | None,
) -> None:
    """Judge every engine, method and setting on the default scenes; accuracy only, nothing is timed alone.

    Records are the same however they are spread: lost workers and shards cost nothing but time.
    """
    from benchmarks import cluster

    for name in chosen:
        inputs.engine(name)
    target = inputs.output(output, (".jsonl",))
    tasks = cluster.plan(quick, list(chosen) or None)
    part = re.fullmatch(r"(\d+)/(\d+)", shard)
    try:
        tasks = cluster.shard(tasks, *(int(part[1]), int(part[2])) if part else (0, 0))
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    if not tasks:
        raise NothingSelected("no runs in this part of the matrix")
    found = {}
    try:
        with progress("matrix") as report:
            for task, record in _spread(tasks, serial, timeout, scheduler, workers):
                found[task] = record
                report(len(found), len(tasks), f"{record.scene} {record.engine} {record.method}")
                if target is not None:
                    record_file.append(Path(target), [finite_record(record)])
    except KeyboardInterrupt:
        raise Incomplete(f"interrupted after {len(found)} of {len(tasks)} runs") from None
    records = [found[task] for task in tasks]
    if as_json:
        for record in records:
            echo_json(record.to_dict(), indent=None)
        return
    listing = table("", "scene", "engine", "method", "status", "error, m", "task, s")
    for r in records:
        figures = (number(r.error.value if r.error else None), number(r.times.get("task_s")))
        listing.add_row(r.scene, r.engine, r.method, r.status, *figures)
    show(listing)


def _spread(tasks, serial: bool, timeout: float, scheduler: str | None, workers: int | None):
    from benchmarks import cluster

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
