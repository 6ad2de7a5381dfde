"""mbs-ref report: the main job."""

import os
import sys
from pathlib import Path

import click

from cross_checks.judge.bounds import TARGETS
from cross_checks.records.numbers import short
from cross_checks.records.store import Store, default_path
from reports import inputs
from reports.console import Incomplete, progress
from reports.query import SCHEDULER, cluster

EXTREMES = "extremes*.jsonl"  # beside the page: what `mbs-ref extremes -o` wrote, whole or in parts
FORMS = ("html", "single", "static", "md", "latex", "pdf", "csv")
DRAWN = ("static", "pdf")  # by a browser
FORM_HELP = "html: pages; the others are one file. single: interactive, to mail; static: the same without scripts."
TARGET = click.Choice([short(target) for target in TARGETS])


@click.command(name="report", epilog="Example: mbs-ref report --quick")
@click.option("--open", "open_it", is_flag=True, help="Open the page in a browser.")
@click.option("--quick", is_flag=True, help="Few scenes, for a first look.")
@click.option("--full", is_flag=True, help="Leave out no run for its cost.")
@click.option("--render", "render_only", is_flag=True, help="Render the data of the last report; simulate nothing.")
@click.option("--retime", is_flag=True, help="Time again what is ranked, even where the store holds times.")
@click.option("--scene", "scenes", multiple=True, metavar="SCENE", help="Only this scene, as 'NAME key=value'; repeat.")
@click.option("--engine", "engines", multiple=True, metavar="NAME", help="Only this engine; repeat it for several.")
@click.option("--target", "targets", multiple=True, type=TARGET, help="Show this error alone; repeat for several.")
@click.option("--format", "form", default=FORMS[0], show_default=True, type=click.Choice(FORMS), help=FORM_HELP)
@click.option("--text", is_flag=True, help="Print advice, prices, verdicts and small plots, too.")
@SCHEDULER
@click.option("-o", "folder", default="reports/out", show_default=True, type=inputs.FOLDER)
def command(
    open_it: bool, quick: bool, full: bool, render_only: bool, retime: bool, scenes: tuple[str, ...],
    engines: tuple[str, ...], targets: tuple[str, ...], form: str, text: bool, scheduler: str | None, folder: Path,
) -> None:  # fmt: skip
    """Run the comparison and write HTML pages that work offline. Their data lie beside them.

    Runs are stored (MBS_REF_STORE, else the cache folder): the next report computes what changed. Times and studies are
    measured on this machine. --scene and --engine restrict what is computed, or with --render what is shown; the
    studies are left out then. After Ctrl-C the pages show what there is, and the exit code is 4.
    """
    from reports.commands.publish.show import chosen, last_report, print_report
    from reports.page.build import BROWSERS, browser, publish, write_report

    errors = [float(target) for target in targets]
    if form in DRAWN and browser() is None:
        raise click.UsageError(f"--format {form} is drawn by a browser; install one of {', '.join(BROWSERS)}")
    if render_only:
        data = last_report(folder)
        labels = [label for scene in scenes for label in chosen(data, scene)]
        if unknown := [name for name in engines if name not in data.engines]:
            raise click.UsageError(f"engine {unknown[0]!r} is not in the report; it holds {', '.join(data.engines)}")
        data = data.only(labels, engines, errors)
        page, incomplete = publish(data, folder, form), data.incomplete
    else:
        from reports.gather import Gathering  # the solver and the engines, which rendering alone does not need

        names = inputs.engine_names(engines) if engines else ()
        with progress("report") as report, cluster(scheduler) as call, Store(default_path()) as store:
            files = sorted(folder.glob(EXTREMES))
            gathering = Gathering(store, quick, report, files, retime, call, scenes, names, full)
            page, incomplete = write_report(folder, gathering.stages(), form, errors)
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
