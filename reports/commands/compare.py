"""mbs-ref compare: is one version of the code slower than another?"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import click

from reports.console import echo_json, progress, show, table
from reports.exit_codes import Failed, Incomplete


@click.command(name="compare")
@click.argument("baseline", metavar="A")
@click.argument("current", metavar="B", default=".")
@click.option("--only", metavar="TEXT", default="", help="Only the cases whose name holds this.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(baseline: str, current: str, only: str, as_json: bool) -> None:
    """Time version B against version A at equal error, in this one job; each a folder or a git revision.

    Exit code 1 where B is slower, 4 where something could not be measured or stayed inconclusive.
    """
    from benchmarks import regression

    cases = [case for case in regression.CASES if only in case.name]
    if not cases:
        raise click.UsageError(f"--only {only!r} fits none of: {', '.join(c.name for c in regression.CASES)}")
    with ExitStack() as stack:
        trees = [stack.enter_context(tree(name)) for name in (baseline, current)]
        report = stack.enter_context(progress("compare"))
        try:
            findings = list(regression.regressions(trees[0], trees[1], cases, report))
        except ValueError as error:
            raise click.UsageError(str(error)) from error
    verdict = regression.overall(findings)
    if as_json:
        echo_json({"verdict": verdict, "cases": [finding.to_dict() for finding in findings]})
    else:
        listing = table("", "case", "verdict", "")
        for finding in findings:
            listing.add_row(finding.case, finding.verdict, finding.sentence)
        show(listing)
    if verdict == "slower":
        raise Failed(f"slower: {', '.join(f.case for f in findings if f.verdict == 'slower')}")
    if verdict in (regression.NOT_MEASURED, "inconclusive"):
        raise Incomplete(f"{verdict}: {', '.join(f.case for f in findings if f.verdict == verdict)}")


@contextmanager
def tree(name: str) -> Iterator[Path]:
    """Yield the folder, or a passing checkout of the git revision."""
    if Path(name).is_dir():
        yield Path(name)
        return
    with tempfile.TemporaryDirectory(prefix="mbs-ref-") as folder:
        archive = ["git", "archive", "--output", f"{folder}/tree.tar", name]
        done = subprocess.run(archive, capture_output=True, text=True, check=False)
        if done.returncode:
            raise click.UsageError(f"{name!r} is neither a folder nor a git revision: {done.stderr.strip()}")
        subprocess.run(["tar", "-xf", "tree.tar"], cwd=folder, check=True)
        yield Path(folder)
