"""mbs-ref check: the cross-validation table, and an exit code that stands for it."""

from __future__ import annotations

import click

from cross_checks.judge.cell import check
from cross_checks.judge.vocabulary import Cell, Refused, refusals
from mbs_ref import scenes
from reports import inputs
from reports.terminal.asking import STORE, asked_runs
from reports.terminal.console import echo_json, number, progress, show, table
from reports.terminal.exit_codes import Failed, Incomplete, NothingSelected

MOST_REASONS = 5  # told where nothing runs


@click.command(name="check")
@click.argument("scene", nargs=-1, metavar="[SCENE|FILE.toml]...")
@inputs.PARAMETERS
@inputs.KEEP
@inputs.ENGINES
@click.option("--json", "as_json", is_flag=True, help="Print JSON: a list of cells.")
@STORE
def command(
    scene: tuple[str, ...], parameters: tuple[str, ...], kept: tuple[str, ...], chosen: tuple[str, ...], as_json: bool,
    store: str | None,
) -> None:  # fmt: skip
    """Compare engines with each other and with the truth, on every SCENE or on those named.

    Where no truth is certified, engines are held against what unlike ones agree on. Runs are made once and kept in a
    store; each engine runs in a process of its own: one that hangs, crashes or eats memory costs its own cell.
    Exit code 1 where a method is wrong where it does not declare that it is known to be.
    """
    for option, given in (("-p", parameters), ("--keep", kept)):
        if given and len(scene) != 1:
            raise click.UsageError(f"{option} {given[0]} needs exactly one SCENE; {len(scene)} are named")
    selected = [inputs.comparable(name, parameters, kept) for name in scene or scenes.names()]
    names = inputs.engine_names(chosen)
    cells: list[Cell] = []
    interrupted = False
    try:
        with progress("check") as report, asked_runs(selected, store) as runs:
            for cell in check(runs, selected, names, report):
                cells.append(cell)
    except KeyboardInterrupt:
        interrupted = True
    if as_json:
        echo_json([cell.to_dict() for cell in cells])
    else:
        _show(cells)
    if interrupted:
        raise Incomplete(f"interrupted after {len(cells)} cells")
    if not any(not cell.is_refused for cell in cells):
        why = {f"{cell.scene} by {cell.engine}": cell.reason for cell in reversed(cells)}  # an engine's first method
        told = [f"{where}: {reason}" for where, reason in reversed(why.items())]
        raise NothingSelected(f"no engine runs any of the scenes. {'. '.join(told[:MOST_REASONS])}")
    wrong = [cell for cell in cells if cell.is_wrong]
    if wrong:
        named = ", ".join(f"{cell.scene}/{cell.engine}/{cell.method}: {cell.verdict}" for cell in wrong)
        raise Failed(f"{len(wrong)} of {len(cells)} cells are wrong: {named}")


def _show(cells: list[Cell]) -> None:
    listing = table("", "scene", "engine", "method", "verdict", "error", "compliance", "order", "reason")
    for cell in cells:
        if cell.is_refused:
            continue
        figures = (number(value) for value in (cell.error, cell.compliance, cell.order))
        exemption = f" (documented: {cell.exemption})" if cell.exemption else ""
        verdict = f"{cell.verdict} {cell.code}"
        listing.add_row(cell.label, cell.engine, cell.method, verdict, *figures, f"{cell.reason}{exemption}")
    show(listing)
    _show_refusals(cells)
    kinds = sorted({cell.truth for cell in cells if cell.truth})
    if kinds:
        click.echo(f"Errors are over each scene's own length and time; truths are {', '.join(kinds)}.", err=True)
    _show_contact([cell for cell in cells if cell.contact])


def _show_refusals(cells: list[Cell]) -> None:
    """List the engines that cannot run a scene by their reasons."""
    listing = table("\nRefused", *Refused._fields)
    for row in refusals(cells):
        listing.add_row(*row)
    if listing.row_count:
        show(listing)


def _show_contact(cells: list[Cell]) -> None:
    """List what contact did in the run that speaks for each cell."""
    if not cells:
        return
    listing = table("\nContact", "scene", "engine", "method", "figures")
    for cell in cells:
        figures = "; ".join(f"{name} {number(value)}" for name, value in cell.contact.items())
        listing.add_row(cell.label, cell.engine, cell.method, figures)
    show(listing)
