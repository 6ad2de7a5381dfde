"""mbs-ref sweep: every engine and method over its ladder of steps or tolerances."""

from pathlib import Path

import click

from cross_checks.records.numbers import setting
from cross_checks.records.record import Record
from mbs_ref.files import write_atomic
from reports import inputs
from reports.console import NothingSelected, echo_json, number, show_table
from reports.query import SCHEDULER, STORE, sweep_records


@click.command(name="sweep", epilog="Example: mbs-ref sweep pendulum_chain -p links=10 -o chain.jsonl")
@inputs.scene_options
@inputs.ENGINES
@click.option("--method", "methods", multiple=True, metavar="M", help="Only this method; repeatable.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines, one a run.")
@click.option("-o", "output", metavar="FILE.jsonl|.parquet", help="Write the runs to a file, as lines or as a table.")
@click.option("--plot", metavar="FILE.html", help="Draw error against the time of the loop, as a page.")
@click.option("--timeout", type=inputs.POSITIVE, help="Longest time a run computes, s.  [default: 120]")
@click.option("--memory", type=inputs.POSITIVE, help="Most memory of one run, MiB.  [default: 4096]")
@SCHEDULER
@STORE
def command(
    scene: str, parameters: tuple[str, ...], keep_rates: tuple[str, ...], chosen: tuple[str, ...],
    methods: tuple[str, ...], as_json: bool, output: str | None, plot: str | None, timeout: float | None,
    memory: float | None, scheduler: str | None, store: str | None,
) -> None:  # fmt: skip
    """Measure work against precision on SCENE. The settings that meet each decade of error are timed.

    Engines run in a process of their own: one that hangs, crashes or eats memory costs that one run.
    A sweep that was interrupted, or killed, goes on where it stopped.
    """
    target = inputs.output(output, (".jsonl", ".parquet"))
    drawn = inputs.output(plot, (".html",))
    columns = target if target is not None and target.suffix == ".parquet" else None
    lines = target if columns is None else None
    built = inputs.comparable(scene, parameters, keep_rates)
    records = sweep_records(built, chosen, methods, lines, timeout, memory, store=store, scheduler=scheduler)
    if not records:
        raise NothingSelected("no engine and method to sweep")
    if columns is not None:
        from reports.page.files import record_columns
        from reports.poses_file import parquet_table

        write_atomic(columns, parquet_table(record_columns(records)))
    if drawn is not None:
        _draw(records, drawn)
    for record in records if as_json else ():
        echo_json(record.to_dict(), indent=None)
    if not as_json:
        _show(records)


def _draw(records: list[Record], target: Path) -> None:
    from cross_checks.records.figures import work_precision

    try:
        page = work_precision(records).to_html(include_plotlyjs=True)
    except ValueError as error:
        raise NothingSelected(f"nothing to plot: {error}") from error
    write_atomic(target, page.encode())


def _show(records: list[Record]) -> None:
    rows = []
    for record in records:
        error, compliance = record.error and record.error.value, record.measure("compliance_position")
        how = setting({key: record.settings.get(key) for key in ("step", "rtol")})
        figures = map(number, (error, compliance, record.times.get("loop_s")))
        rows.append((record.engine, record.method, how, record.status, *figures))
    show_table("", ("engine", "method", "setting", "status", "error", "compliance", "loop, s"), rows)
