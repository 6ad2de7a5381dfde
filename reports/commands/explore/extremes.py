"""mbs-ref extremes: up to where each engine and method can be trusted."""

from contextlib import ExitStack
from dataclasses import asdict, replace
from datetime import UTC, datetime

import click

from cross_checks.extremes.fate import Cell, Fate
from cross_checks.records import lines
from reports import inputs
from reports.console import Failed, NothingSelected, echo_json, interruptible, number, progress, show_table
from reports.query import SCHEDULER, begun, cluster


@click.command(name="extremes", epilog="Example: mbs-ref extremes --only stiffness")
@click.option("--full", is_flag=True, help="Every method and value, with long time limits.")
@click.option("--only", metavar="TEXT", help="Only extremes whose name or family holds this.")
@inputs.ENGINES
@inputs.SHARD
@SCHEDULER
@click.option("--json", "as_json", is_flag=True, help="Print JSON lines, one a cell.")
@click.option(
    "-o", "output", metavar="FILE.jsonl", help="Add the cells to a file; those that it holds are not run again."
)
def command(
    full: bool, only: str | None, chosen: tuple[str, ...], shard: str, scheduler: str | None, as_json: bool,
    output: str | None,
) -> None:  # fmt: skip
    """Drive scenes to the edge, and show where engines fail. They stop, degrade or are silently wrong.

    Every run has a process of its own; two run at a time. Exit code 1 where the reference solver is
    silently wrong anywhere; other engines' failures are findings.
    """
    from cross_checks.extremes import every, fate, run
    from reports.facts.environment import commit

    names = inputs.engine_names(chosen)
    extremes = [e for e in every() if only is None or only in e.name or only in e.family]
    if not extremes:
        raise NothingSelected(f"no extreme is named like {only!r}; there are {', '.join(e.name for e in every())}")
    extremes = inputs.shard(extremes, shard)
    target, made = inputs.output(output, (".jsonl",)), f"{datetime.now(UTC):%Y-%m-%d}, revision {commit()}"
    with ExitStack() as stack:
        report = stack.enter_context(progress("extremes"))
        call = stack.enter_context(cluster(scheduler))
        result = begun(stack, target, fate.read)
        stack.enter_context(interruptible(lambda: f"{len(result)} cells"))
        for one in run.matrix(extremes, names, full=full, known=tuple(result), progress=report, call=call):
            result.append(replace(one, made=made))
            if target is not None:
                lines.append(target, result[-1:])
    names = {e.name for e in extremes}
    shown = [c for c in result if c.extreme in names and c.full == full and (not chosen or c.engine in chosen)]
    for one in shown if as_json else ():
        echo_json(asdict(one), indent=None)
    if not as_json:
        _show(shown)
    ours = [c for c in shown if c.engine == "mbs_ref" and c.fate is Fate.SILENTLY_WRONG]
    if ours:
        listing = "; ".join(f"{c.extreme} {c.method}: {c.reason}" for c in ours[:8])
        raise Failed(f"mbs_ref is silently wrong in {len(ours)} cells: {listing}")


def _show(cells: list[Cell]) -> None:
    from cross_checks.extremes import named

    rows = []
    wanted = [c for c in cells if c.fate is not Fate.CANNOT]
    for one in sorted(wanted, key=lambda c: (c.family, c.extreme, c.engine != "mbs_ref", c.engine, c.method)):
        axis = named(one.extreme).axis
        last = "-" if one.last is None else f"{axis.name} {axis.label(one.last)} {'' if axis.labels else axis.unit}"
        rows.append((one.extreme, one.engine, one.method, one.fate, last.strip(), one.reason[:90]))
    show_table("", ("extreme", "engine", "method", "fate", "all right up to", "what came first beyond"), rows)
    counts = {fate: sum(c.fate is fate for c in cells) for fate in Fate}
    caught = sum(point.caught for c in cells for point in c.points)
    click.echo(", ".join(f"{fate} {count}" for fate, count in counts.items()))
    click.echo(f"failures that the engine did not report and our checks detected: {number(caught)}")
