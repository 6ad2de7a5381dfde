"""mbs-ref report: the main job."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click

from reports.console import progress
from reports.exit_codes import Incomplete

FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command(name="report")
@click.option("--open", "open_it", is_flag=True, help="Open the page in a browser.")
@click.option("--quick", is_flag=True, help="Fewer scenes and settings, for a first look.")
@click.option("-o", "folder", default="reports/out", show_default=True, type=FOLDER)
def command(open_it: bool, quick: bool, folder: Path) -> None:
    """Run the comparison and write one HTML page that works offline, with its data beside it."""
    from reports.page.build import write_report

    with progress("report") as report:
        page, incomplete = write_report(folder, quick, report)
    click.echo(page)
    if incomplete:
        raise Incomplete(f"{incomplete}; the page shows what there is")
    if open_it and not _open(page):
        click.echo(f"No browser here: open {page.resolve().as_uri()} yourself.", err=True)


def _open(page: Path) -> bool:
    """Open the page where there is a screen; a text browser would only block."""
    screen = sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return bool(screen) and click.launch(page.resolve().as_uri()) == 0
