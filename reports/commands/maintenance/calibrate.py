"""mbs-ref calibrate: are the reference solver's own error estimates honest?"""

from pathlib import Path
from typing import Any

import click

from cross_checks.records import lines
from reports import console, inputs
from reports.console import Failed, NothingSelected, echo_json, interruptible, number, progress, show_table

MOST_BELOW = 0.01  # share of the judged runs whose error may be above the estimate
MOST_ABOVE = 10.0  # median of estimate over error


@click.command(name="calibrate", epilog="Example: mbs-ref calibrate -n 20")
@click.option("-n", "count", type=click.IntRange(min=1), default=500, show_default=True, help="Number of random runs.")
@click.option("--first", type=click.IntRange(min=0), default=0, show_default=True, help="The first run's seed.")
@inputs.SHARD
@click.option("--keep", type=inputs.NEW_FILE, help="JSON lines: runs that it holds are not repeated, others are added.")
@click.option("--proven", is_flag=True, help="Certified scenes whose stored truths are proven, as those truths.")
@console.table_file("calibration")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: the table, and every run.")
def command(
    count: int, first: int, shard: str, keep: Path | None, proven: bool, target: Path | None, as_json: bool
) -> None:
    """Compare error estimates of random runs with their errors. More accurate runs show the errors.

    Mechanisms, scenes, methods and settings are random. Exit code 1 where more than 1 % of the judged runs have an
    error above the estimate, or where the median estimate is more than ten times the error. With --keep an interrupted
    calibration resumes.
    """
    if keep and proven:
        raise click.UsageError("--keep stores runs of random scenes; give it no --proven")
    from benchmarks import calibration

    seeds = inputs.shard(list(range(first, first + count)), shard)
    known, among = calibration.stored(keep) if keep else {}, calibration.proven() if proven else []
    result = [known[seed] for seed in seeds if seed in known]
    with interruptible(lambda: f"{len(result)} runs"), progress("calibrate") as report:
        for seed in [seed for seed in seeds if seed not in known]:
            report(len(result), len(seeds), f"seed {seed}")
            result.append(calibration.trial(seed, among))
            if keep:
                lines.append(keep, [result[-1]])
    rows, below = calibration.table(result), [one for one in result if one.is_below]
    if target:
        text = [calibration.to_dict(one) for one in below]
        facts = {"first": first, "runs": len(result), "table": rows, "below": text}
        console.write_table(facts, target)
    if as_json:
        echo_json({"table": rows, "runs": [calibration.to_dict(one) for one in result]})
    else:
        _show(rows)
        if below:
            head = ("seed", "scene", "method", "setting", "error", "estimate")
            rows_below = ((o.seed, o.scene, o.method, o.setting, number(o.error), number(o.estimate)) for o in below)
            show_table("\nAbove their estimate", head, rows_below)
    _judge(rows[0])


def _judge(row: dict[str, Any]) -> None:
    if not row["judged"]:
        raise NothingSelected("no run could be judged")
    if row["share_below"] > MOST_BELOW:
        raise Failed(f"{row['below']} of {row['judged']} runs have an error above their estimate")
    if row["overestimate_median"] is not None and row["overestimate_median"] > MOST_ABOVE:
        raise Failed(f"the median estimate is {row['overestimate_median']:.3g} times the error")


def _show(rows: list[dict[str, Any]]) -> None:
    over = ("1 % have less", "median", "90 % have less")
    words = ("method", "runs", "judged", "below")
    keys = ("overestimate_1", "overestimate_median", "overestimate_90", "cost_median")
    shown = ([*(row[word] for word in words), *(number(row[key]) for key in keys)] for row in rows)
    show_table("Estimate over error", (*words[:3], "above their estimate", *over, "cost, loops"), shown)
