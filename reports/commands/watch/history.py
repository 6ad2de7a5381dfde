"""mbs-ref history: what the nightly jobs found, and where it changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from benchmarks import history
from benchmarks.history import Entry
from reports import inputs
from reports.terminal.console import echo_json, number, show, table
from reports.terminal.exit_codes import NothingSelected

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.command(name="history")
@click.option("--file", "file", type=FILE, default="reports/out/history.jsonl", show_default=True, help="The lines.")
@click.option("--series", "text", default="", metavar="TEXT", help="Only series whose name holds this.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("-o", "output", metavar="FILE.html", help="Draw the trends.")
def command(file: Path, text: str, as_json: bool, output: str | None) -> None:
    """Show every series over time with its change points."""
    target = inputs.output(output, (".html",))
    database, problems = history.index(file)
    for problem in problems:
        click.echo(problem, err=True)
    found = history.series(database, text)
    if not found:
        raise NothingSelected(f"no series in {file} holds {text!r}")
    changes = {name: history.change_points([e.value for e in entries]) for name, entries in found.items()}
    if target is not None:
        from reports.drawing.plots.trend import write_trends

        write_trends(found, changes, target)
    if as_json:
        echo_json({name: _facts(entries, changes[name]) for name, entries in found.items()})
        return
    listing = table("", "series", "jobs", "last", "unit", "verdict", "changed at")
    for name, entries in found.items():
        last, when = entries[-1], ", ".join(entries[k].made for k in changes[name])
        listing.add_row(name, str(len(entries)), number(last.value), last.unit, last.verdict, when or "never")
    show(listing)


def _facts(entries: list[Entry], changes: list[int]) -> dict[str, Any]:
    return {"values": [e.value for e in entries], "changes": [entries[k].made for k in changes]}
