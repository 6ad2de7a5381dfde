"""mbs-ref report: the main job."""

import os
import sys
from pathlib import Path

import click

from cross_checks.records.store import Store, default_path
from reports.query import SCHEDULER, cluster
from reports.terminal.console import Incomplete, NothingSelected, progress

EXTREMES = "extremes*.jsonl"  # beside the page: what `mbs-ref extremes -o` wrote, whole or in parts
FOLDER = click.Path(file_okay=False, path_type=Path)


@click.command(name="report", epilog="Example: mbs-ref report --quick")
@click.option("--open", "open_it", is_flag=True, help="Open the page in a browser.")
@click.option("--quick", is_flag=True, help="Few scenes, for a first look.")
@click.option("--render", "render_only", is_flag=True, help="Render the data of the last report; simulate nothing.")
@click.option("--retime", is_flag=True, help="Time again what is ranked, even where the store holds times.")
@click.option("--text", is_flag=True, help="Print advice, prices, verdicts and small plots, too.")
@SCHEDULER
@click.option("-o", "folder", default="reports/out", show_default=True, type=FOLDER)
def command(
    open_it: bool, quick: bool, render_only: bool, retime: bool, text: bool, scheduler: str | None, folder: Path
) -> None:
    """Run the comparison and write HTML pages that work offline. Their data lie beside them.

    Runs are stored (MBS_REF_STORE, else the cache folder): the next report computes what changed. Times and studies are
    measured on this machine. After Ctrl-C the pages show what there is, and the exit code is 4.
    """
    from reports.commands.publish.show import last_report, print_report
    from reports.page.build import render_again, write_report

    if render_only:
        try:
            page, incomplete = render_again(folder)
        except (FileNotFoundError, ValueError) as error:
            raise NothingSelected(
                f"{folder} holds no data to render; compute them by mbs-ref report ({error})"
            ) from error
    else:
        from reports.gather import Gathering  # the solver and the engines, which rendering alone does not need

        with progress("report") as report, cluster(scheduler) as call, Store(default_path()) as store:
            gathering = Gathering(store, quick, report, sorted(folder.glob(EXTREMES)), retime, call)
            page, incomplete = write_report(folder, gathering.stages())
    if text:
        print_report(last_report(folder))
    click.echo(page)
    if incomplete:
        raise Incomplete(f"{incomplete}; the page shows what there is")
    if open_it and not _open(page):
        click.echo(f"No browser here: open {page.resolve().as_uri()} yourself.", err=True)


def _open(page: Path) -> bool:
    """Open the page where there is a screen; a text browser would only block."""
    screen = sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return bool(screen) and click.launch(page.resolve().as_uri()) == 0
