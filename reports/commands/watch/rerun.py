"""mbs-ref rerun: make a cell of the report again, whatever the store holds."""

from __future__ import annotations

import click

from cross_checks import engines
from cross_checks.judge.cell import judge_method, truth_of
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store
from reports import inputs
from reports.asking import isolated
from reports.console import echo_json, number, show, table
from reports.exit_codes import Failed


@click.command(name="rerun")
@click.argument("cell", metavar="SCENE[,NAME=VALUE...]/ENGINE/METHOD")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(cell: str, as_json: bool) -> None:
    """Make every run of a CELL of the report again and judge it; nothing is taken from the store or kept in it.

    For example mbs-ref rerun pendulum_chain,links=3/mujoco/rk4. Exit code 1 where the verdict accuses the method.
    """
    named = cell.split("/")
    if len(named) != 3:
        raise click.UsageError(f"cell {cell!r} must be SCENE[,NAME=VALUE...]/ENGINE/METHOD")
    (name, *parameters), engine, method = named[0].split(","), named[1], named[2]
    scene, solver = inputs.scene(name, parameters), inputs.engine(engine)
    chosen = engines.get(engine).method(inputs.method(solver, method))
    with isolated((scene,)) as call:
        runs = Runs(Store(), call)
        found = judge_method(runs, scene, engine, chosen, truth_of(runs, scene))
    if as_json:
        echo_json(found.to_dict())
    else:
        _tables(found)
    if found.is_wrong:
        raise Failed(f"{cell}: {found.verdict}")


def _tables(found) -> None:
    listing = table(
        f"{found.scene} {found.engine} {found.method}: {found.verdict}, {found.reason}", "setting", "status", "error"
    )
    for run in found.runs:
        listing.add_row(run["setting"], run["status"], number(run["error"]))
    show(listing)
    targets = table("\nTargets", "target", "answer", "setting or reason", "loop, s")
    for reached in found.targets:
        record = reached.record
        told = (
            reached.reason
            if record is None
            else ", ".join(f"{k}={v}" for k, v in record.settings.items() if k in ("step", "rtol"))
        )
        loop = None if record is None else record.times.get("loop_s")
        targets.add_row(f"{reached.target:g}", reached.answer, told, number(loop))
    show(targets)
