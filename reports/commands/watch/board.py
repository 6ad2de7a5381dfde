"""mbs-ref board: one page of a release, engines ranked at equal error."""

from __future__ import annotations

from pathlib import Path

import click

from mbs_ref.atomic_file import write_atomic
from reports import inputs
from reports.commands.watch.show import FOLDER, last_report


@click.command(name="board")
@click.option("-o", "output", default="board.html", show_default=True, metavar="FILE.html", help="Where to write.")
@click.option("--from", "folder", default="reports/out", show_default=True, type=FOLDER, help="Where the report is.")
def command(output: str, folder: Path) -> None:
    """Write a page that stands alone from the last report's records: who is cheapest at equal error, who goes wrong.

    Nothing is run. Every number has the command that makes it again, every claim an anchor to link to; our own solver
    is shown apart, and ranked nowhere.
    """
    from reports.page.board import board

    target = inputs.output(output, (".html",))
    assert target is not None
    write_atomic(target, board(last_report(folder)))
    click.echo(str(target))
