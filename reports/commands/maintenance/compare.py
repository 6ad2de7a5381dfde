"""mbs-ref compare: is one version of the code slower than another, or one file of records worse?"""

import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cross_checks.records import lines as record_file
from cross_checks.records.record import Record
from reports import console

if TYPE_CHECKING:
    from benchmarks.trees.regression import Case, Finding


@click.command(name="compare", epilog="Example: mbs-ref compare HEAD~1 .")
@click.argument("baseline", metavar="A")
@click.argument("current", metavar="B", default=".")
@click.option("--only", metavar="TEXT", default="", help="Only the cases whose name holds this.")
@click.option("--slowed", type=click.FloatRange(0.0, 1000.0), metavar="PERCENT",
              help="Take as B a copy of this tree whose planar kernel is slower on the first case.")  # fmt: skip
@click.option("--rates", is_flag=True, help="Time right-hand sides instead, A and B in turns, without a verdict.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(baseline: str, current: str, only: str, slowed: float | None, rates: bool, as_json: bool) -> None:
    """Time version B against version A at equal error. Both run in this one job.

    Each is a folder or a git revision.
    Where A and B are files of records (.jsonl), their accuracy is compared run by run; their times were
    measured in different jobs and decide nothing. Exit code 1 where B is slower or worse, 4 where
    something could not be measured or stayed inconclusive, 5 where the files share no run.
    """
    from benchmarks.trees import regression

    files = [Path(name) for name in (baseline, current) if name.endswith(".jsonl")]
    if files:
        _compare_files(files, only, as_json)
        return
    if rates:
        _compare_rates(baseline, current, only, as_json)
        return
    cases = [case for case in regression.CASES if only in case.name]
    if not cases:
        raise click.UsageError(f"--only {only!r} fits none of: {', '.join(c.name for c in regression.CASES)}")
    findings = findings_of("compare", baseline, current, cases, slowed)
    verdict = regression.overall(findings)
    if as_json:
        console.echo_json({"verdict": verdict, "cases": findings})
    else:
        console.show_table("", ("case", "verdict", ""), ((f.case, f.verdict, f.sentence) for f in findings))
    end(findings)


def _compare_rates(baseline: str, current: str, only: str, as_json: bool) -> None:
    from benchmarks.trees.regression import STATED, Rate, Tree, rate_of

    with tree(baseline) as before, tree(current) as after, Tree(before) as old, Tree(after) as new:
        found = [rate_of(old, new, scene, parameters) for scene, parameters in STATED["rates"] if only in scene]
    if as_json:
        console.echo_json([one._asdict() for one in found])
    else:
        rows = ((*one[:2], *map(console.number, one[2:])) for one in found)
        console.show_table("Processor time of a right-hand side", Rate._fields, rows)


def findings_of(
    title: str, baseline: str, current: str, cases: "Sequence[Case]", slowed: float | None = None
) -> "list[Finding]":
    """Return the verdicts on two trees, each a folder or a git revision; with `slowed` B is a copy of this tree."""
    from benchmarks.trees import regression
    from benchmarks.trees import slowed as copies

    with ExitStack() as stack:
        before = stack.enter_context(tree(baseline))
        if slowed is None:
            after = stack.enter_context(tree(current))
        else:
            after = copies.copy_tree(Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="mbs-ref-"))))
            turns, share = copies.calibrate(after, cases[0], slowed / 100.0) if slowed > 0.0 else (0, 0.0)
            sentence = f"B takes {share:.1%} longer on {cases[0].name}, by {turns} square roots a right-hand side"
            click.echo(sentence, err=True)
        report = stack.enter_context(console.progress(title))
        stack.enter_context(console.reported_as(click.UsageError, ValueError))
        return list(regression.regressions(before, after, cases, report))


def end(findings: "Sequence[Finding]", worse: int = 0) -> None:
    """End the command with the exit code of the verdicts, and of so many runs that are less accurate than before."""
    from benchmarks.trees import regression

    verdict = regression.overall(findings)
    named = ", ".join(finding.case for finding in findings if finding.verdict == verdict)
    reasons = [f"slower: {named}"] * (verdict == "slower") + [f"{worse} runs worse than last night"] * bool(worse)
    if reasons:
        raise console.Failed("; ".join(reasons))
    if verdict in (regression.NOT_MEASURED, "inconclusive"):
        raise console.Incomplete(f"{verdict}: {named}")


def _compare_files(files: list[Path], only: str, as_json: bool) -> None:
    from benchmarks import record_changes
    from benchmarks.record_changes import Move

    if len(files) != 2:
        raise click.UsageError("A and B must be two trees, or two files of records")
    before, after = (_records(file) for file in files)
    result = [change for change in record_changes.changes(before, after) if only in change.run]
    if not result:
        raise console.NothingSelected(f"{files[0]} and {files[1]} share no run{f' named {only!r}' if only else ''}")
    verdict, ratio = record_changes.overall(result), record_changes.median_ratio(result)
    left, right = record_changes.alone(before, after)
    if as_json:
        facts = {"verdict": verdict, "median_time_ratio": ratio, "only_in_a": left, "only_in_b": right}
        console.echo_json(facts | {"runs": result})
    else:
        changed = [(c.run, c.move, c.sentence, console.number(c.ratio)) for c in result if c.move is not Move.SAME]
        console.show_table("", ("run", "verdict", "", "loop, B/A"), changed)
        counts = ", ".join(f"{sum(c.move is move for c in result)} {move}" for move in Move)
        click.echo(f"{len(result)} runs in both: {counts}. {left} only in A, {right} only in B.")
        click.echo(
            f"The median ratio of loop times, B/A, is {console.number(ratio)}; times of two jobs decide nothing."
        )
    if verdict is Move.WORSE:
        raise console.Failed(f"worse: {sum(c.move is Move.WORSE for c in result)} of {len(result)} runs")
    if verdict is Move.NOT_MEASURED:
        raise console.Incomplete("some runs could not be compared")


def _records(file: Path) -> list[Record]:
    if not file.is_file():
        raise click.UsageError(f"{file}: there is no such file")
    records, problems = record_file.read(file)
    console.complain(problems)
    return records


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
