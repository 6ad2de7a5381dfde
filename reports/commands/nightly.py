"""mbs-ref nightly: regression verdicts against a baseline in the same job, kept in the history."""

from __future__ import annotations

import json
import platform
import uuid
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path

import click

from reports.commands.compare import tree
from reports.console import progress
from reports.exit_codes import Failed, Incomplete
from reports.page.environment import environment

FILE = click.Path(dir_okay=False, path_type=Path)


@click.command(name="nightly")
@click.option("--baseline", default="HEAD~1", show_default=True, help="A folder or git revision to compare with.")
@click.option("--bench", type=FILE, help="A pytest-benchmark JSON file to add to the history.")
@click.option("--file", type=FILE, default="reports/out/history.jsonl", show_default=True, help="The history.")
@click.option("--only", metavar="TEXT", default="", help="Only the cases whose name holds this.")
def command(baseline: str, bench: Path | None, file: Path, only: str) -> None:
    """Time this tree against the baseline, append to the history, and say whether it became slower.

    Exit code 1 where it is slower, 4 where something could not be measured or stayed inconclusive.
    """
    from benchmarks import history, regression

    cases = [case for case in regression.CASES if only in case.name]
    with ExitStack() as stack:
        trees = [stack.enter_context(tree(name)) for name in (baseline, ".")]
        report = stack.enter_context(progress("nightly"))
        findings = list(regression.regressions(trees[0], trees[1], cases, report))
    facts = environment()
    where = (uuid.uuid4().hex, datetime.now(UTC).isoformat(timespec="seconds"), facts["commit"], platform.node())
    entries = [
        history.Entry(*where, f"ratio {f.case}", f.timing.ratio, "1", f.verdict, f.error) for f in findings if f.timing
    ]
    if bench is not None:
        entries += history.from_benchmarks(json.loads(bench.read_text()), *where)
    history.append(file, entries)
    for finding in findings:
        click.echo(f"{finding.case}: {finding.verdict}: {finding.sentence}")
    verdict = regression.overall(findings)
    if verdict == "slower":
        raise Failed("slower than the baseline")
    if verdict in (regression.NOT_MEASURED, "inconclusive"):
        raise Incomplete(f"{verdict}: see the lines above")
