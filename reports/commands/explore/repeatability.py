"""mbs-ref repeatability: does each engine give the same bits again?"""

from pathlib import Path
from typing import Any

import click

from reports import inputs
from reports.console import ONLY, Failed, answer, named, progress, show_table, table_file

SAME_MACHINE = ("at once", "another process", "another order")  # what our own solver must repeat to the last bit


@click.command(name="repeatability", epilog="Example: mbs-ref repeatability")
@inputs.ENGINES
@ONLY
@table_file("repeatability")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(chosen: tuple[str, ...], only: str | None, target: Path | None, as_json: bool) -> None:
    """Repeat runs in several ways and compare their bits.

    At once, in another process, in the opposite order and with two threads.
    Every method of every engine. Exit code 1 where runs of the reference solver with one thread differ; other
    differences are listed.
    """
    from cross_checks.conformance import repeatability
    from cross_checks.conformance.cases import BLAS, cases

    wanted = named(cases(inputs.engine_names(chosen), BLAS), only)
    with progress("repeatability") as report:
        result = repeatability.measured(wanted, report)
    facts = {"methods": repeatability.by_method(result), "runs": result}
    answer(facts, target, as_json, _show)
    ours = [one for one in result if one["engine"] == "mbs_ref" and _differs_here(one["differs"])]
    if ours:
        raise Failed("mbs_ref gives other bits: " + ", ".join(f"{one['method']} on {one['scene']}" for one in ours))


def _differs_here(differs: dict[str, float | None]) -> bool:
    """Return whether some way on the same machine gave other bits, or None: another end than the plain run's."""
    return any(differs.get(way, 0.0) != 0.0 for way in SAME_MACHINE)


def _show(facts: dict[str, Any]) -> None:
    rows = facts["methods"]
    ways = [each["way"] for each in rows[0]["ways"]]
    head, shown = ("engine", "method", "runs"), []
    for row in rows:
        shown.append([*(row[name] for name in head), *map(_difference, row["ways"])])
    show_table("Runs with other bits, and by how much of the largest value", (*head, *ways), shown)


def _difference(each: dict[str, Any]) -> str:
    if not each["differ"]:
        return "-"
    ended = f", {each['other_end']} end otherwise" if each["other_end"] else ""
    return f"{each['differ']}: {each['largest'] or 0.0:.1e}{ended}"
