"""mbs-ref check: the cross-validation table, and an exit code that stands for it."""

from __future__ import annotations

from typing import Any

import click

from cross_checks import engines
from cross_checks.isolation.parent import Isolated
from mbs_ref import scenes
from reports import inputs
from reports.console import echo_json, number, progress, show, table
from reports.exit_codes import Failed, Incomplete, NothingSelected

WRONG = frozenset({"failed", "wrong-limit", "diverged", "crashed", "timeout", "out-of-memory"})


@click.command(name="check")
@click.argument("scene", nargs=-1)
@click.option("-p", "parameters", multiple=True, metavar="NAME=VALUE", help="A parameter of the scene; repeatable.")
@click.option("--engine", "chosen", multiple=True, metavar="E", help="Only this engine; repeatable.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: a list of cells.")
def command(scene: tuple[str, ...], parameters: tuple[str, ...], chosen: tuple[str, ...], as_json: bool) -> None:
    """Compare engines with each other and with the truth, on every SCENE or on those named.

    Engines run in a process of their own: one that hangs, crashes or eats memory costs its own cell.
    Exit code 1 where a method is wrong without declaring that it is known to be.
    """
    if parameters and len(scene) != 1:
        raise click.UsageError(f"-p {parameters[0]} needs exactly one SCENE; {len(scene)} are named")
    selected = [inputs.scene(name, parameters) for name in scene or scenes.names()]
    for name in chosen:
        inputs.engine(name)

    from cross_checks.judge import matrix

    rows, interrupted = [], False
    try:
        with progress("check") as report, Isolated(matrix.CELL_TIMEOUT) as call:
            for cell in matrix.check(selected, list(chosen) or engines.names(), report, call=call):
                rows.append(cell.to_dict())
    except KeyboardInterrupt:
        interrupted = True
    if as_json:
        echo_json(rows)
    else:
        _show(rows)
    if interrupted:
        raise Incomplete(f"interrupted after {len(rows)} cells")
    if not any(row["verdict"] not in ("cannot", "engine-missing") for row in rows):
        raise NothingSelected("no engine runs any of the scenes; the reasons are in the table")
    unexpected = [row for row in rows if row["verdict"] in WRONG and not _declared(row["engine"], row["method"])]
    if unexpected:
        named = ", ".join(f"{row['scene']}/{row['engine']}/{row['method']}: {row['verdict']}" for row in unexpected)
        raise Failed(f"{len(unexpected)} of {len(rows)} cells are wrong: {named}")


def _declared(engine: str, method: str | None) -> bool:
    """Return whether the method itself says that it is known to go wrong somewhere."""
    return any(m.name == method and m.wrong_limit for m in engines.get(engine).methods())


def _show(rows: list[dict[str, Any]]) -> None:
    listing = table("", "scene", "engine", "method", "verdict", "error", "compliance", "order", "reason")
    for row in rows:
        figures = (number(row[key]) for key in ("error", "compliance", "order"))
        listing.add_row(row["scene"], row["engine"], row["method"] or "", row["verdict"], *figures, row["reason"] or "")
    show(listing)
    _show_contact([row for row in rows if row.get("contact")])


def _show_contact(rows: list[dict[str, Any]]) -> None:
    """List what contact did in the run that speaks for each cell."""
    if not rows:
        return
    listing = table("\nContact", "scene", "engine", "method", "figures")
    for row in rows:
        figures = "; ".join(f"{name} {number(value)}" for name, value in row["contact"].items())
        listing.add_row(row["scene"], row["engine"], row["method"] or "", figures)
    show(listing)
