"""mbs-ref rerun: make a cell of the report again, whatever the store holds."""

import click

from cross_checks import engines
from cross_checks.extremes import every, named
from cross_checks.extremes.fate import Fate
from cross_checks.extremes.run import cell_of
from cross_checks.isolation.parent import Isolated
from cross_checks.judge.cell import judged, truth_of
from cross_checks.judge.runs import Runs
from cross_checks.judge.vocabulary import Cell
from cross_checks.records.numbers import setting
from cross_checks.records.store import Store
from reports import inputs
from reports.console import Failed, answer, echo_json, number, show_table
from reports.query import isolated
from reports.studies.study import every as studies
from reports.studies.study import measure


@click.command(name="rerun", epilog="Example: mbs-ref rerun pendulum_chain,links=3/mujoco/rk4")
@click.argument("cell", metavar="CELL")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(cell: str, as_json: bool) -> None:
    """Repeat a CELL of the report, without the store.

    SCENE[,NAME=VALUE...]/ENGINE/METHOD judges a method anew: mbs-ref rerun pendulum_chain,links=3/mujoco/rk4.
    EXTREME/ENGINE/METHOD drives it along an extreme's axis: mbs-ref rerun overflow/exudyn/trapezoidal.
    STUDY measures a study: mbs-ref rerun space. Exit code 1 where the method is wrong.
    """
    parts = cell.split("/")
    if cell in studies():
        echo_json(measure(cell))
    elif len(parts) != 3:
        raise click.UsageError(f"cell {cell!r} must be SCENE[,NAME=VALUE...]/ENGINE/METHOD, EXTREME/ENGINE/METHOD or "
                               f"one of {', '.join(studies())}")  # fmt: skip
    elif parts[0] in {extreme.name for extreme in every()}:
        _extreme(*parts)
    else:
        _judge(cell, as_json)


def _extreme(name: str, engine: str, method: str) -> None:
    """Drive a method along the axis of an extreme, in a process of its own."""
    solver = inputs.engine(engine)
    chosen = solver.method(inputs.method(solver, method))
    with Isolated() as call:
        results = cell_of(named(name), solver, chosen, False, call)
    echo_json(results)
    if results.fate == Fate.SILENTLY_WRONG:
        raise Failed(f"{name}/{engine}/{method}: {results.fate}")


def _judge(cell: str, as_json: bool) -> None:
    """Judge a method on a scene by runs that are all executed again."""
    first, engine, method = cell.split("/")
    name, *parameters = first.split(",")
    scene, solver = inputs.scene(name, parameters), inputs.engine(engine)
    chosen = engines.get(engine).method(inputs.method(solver, method))
    with isolated((scene,)) as call:
        runs = Runs(Store(), call)
        results, _ = judged(runs, scene, engine, chosen, truth_of(runs, scene))
    answer(results.to_dict(), None, as_json, lambda _: _tables(results))
    if results.is_wrong:
        raise Failed(f"{cell}: {results.verdict}")


def _tables(results: Cell) -> None:
    title = f"{results.label} {results.engine} {results.method}: {results.verdict} {results.code}, {results.reason}"
    runs = ((run["setting"], run["status"], number(run["error"])) for run in results.runs)
    show_table(title, ("setting", "status", "error"), runs)
    rows = []
    for result in results.targets:
        run = result.record
        how = result.reason if run is None else setting(run.settings)
        rows.append((f"{result.target:g}", result.answer, how, number(run and run.times.get("loop_s"))))
    show_table("\nTargets", ("target", "answer", "setting or reason", "loop, s"), rows)
