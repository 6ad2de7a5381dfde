"""mbs-ref nightly: regression verdicts against a baseline in the same job, sweeps, change points, all stored."""

import json
import platform
import shutil
import uuid
from datetime import UTC, datetime
from pathlib import Path

import click

from benchmarks import history, record_changes
from benchmarks.history import Entry
from benchmarks.record_changes import Move
from benchmarks.trees import regression
from cross_checks.records import lines as record_file
from mbs_ref import scenes
from mbs_ref.files import package_data
from reports import inputs
from reports.commands.maintenance.compare import end, findings_of
from reports.commands.maintenance.history import write_trends
from reports.console import NothingSelected, complain
from reports.facts.environment import environment
from reports.query import sweep_records

SWEPT = package_data("reports", "scenes.toml")["nightly"]
ERROR = 1e-6  # of the scene, at which the cheapest loop times are followed
Where = tuple[str, str, str, str]  # job, time, commit, machine


@click.command(name="nightly", epilog="Example: mbs-ref nightly")
@click.option("--baseline", default="HEAD~1", show_default=True, help="A folder or git revision to compare with.")
@click.option("--bench", type=inputs.NEW_FILE, help="A pytest-benchmark JSON file to add to the history.")
@click.option("--file", type=inputs.NEW_FILE, default="reports/out/history.jsonl", show_default=True, help="History.")
@click.option("--sweeps", type=inputs.FOLDER, help="Sweep the default scenes into this folder; the last is moved.")
@click.option("--trends", type=inputs.NEW_FILE, help="Draw the history to this HTML file.")
@click.option("--only", metavar="TEXT", default="", help="Only the cases and scenes whose name holds this.")
def command(baseline: str, bench: Path | None, file: Path, sweeps: Path | None, trends: Path | None, only: str) -> None:
    """Time this tree against the baseline and state changes. They are stored in the history.

    Exit code 1 where it is slower, or a sweep less accurate than last night's; 4 where something could not
    be measured or stayed inconclusive, and nothing is slower.
    """
    cases = [case for case in regression.CASES if only in case.name]
    if not cases:
        names = "; ".join(case.name for case in regression.CASES)
        raise NothingSelected(f"--only {only!r} is in the name of no case: {names}")
    facts = environment()
    where = (uuid.uuid4().hex, datetime.now(UTC).isoformat(timespec="seconds"), facts["commit"], platform.node())
    findings = findings_of("nightly", baseline, ".", cases)
    for finding in findings:
        click.echo(f"{finding.case}: {finding.verdict}: {finding.sentence}")
    entries = [Entry(*where, f"ratio {f.case}", f.timing.ratio, "1", f.verdict, f.error) for f in findings if f.timing]
    if bench is not None:
        entries += history.from_benchmarks(json.loads(bench.read_text()), *where)
    changes = []
    if sweeps is not None:
        swept, changes = _sweep(sweeps, only, where)
        entries += swept
    record_file.append(file, entries)
    _report_history(file, trends)
    worse = [change for change in changes if change.move is Move.WORSE]
    for change in worse:
        click.echo(f"{change.run}: worse than last night: {change.sentence}")
    end(findings, len(worse))


def _sweep(folder: Path, only: str, where: Where) -> tuple[list[Entry], list[record_changes.Change]]:
    """Sweep the default scenes anew; return each engine's cheapest time, and what changed since last night."""
    before = folder.with_name(f"{folder.name}-before")
    if folder.exists():
        shutil.rmtree(before, ignore_errors=True)
        folder.rename(before)
    entries, changes = [], []
    built = [scenes.make(name, **parameters) for name, parameters in SWEPT]
    for scene in built:
        label = scenes.label(scene.name, scene.parameters)
        if only not in label:
            continue
        name = f"{label.replace(' ', '_')}.jsonl"
        records = sweep_records(scene, (), (), folder / name)
        entries += history.from_records(records, label, ERROR, *where)
        if (before / name).is_file():
            changes += record_changes.changes(record_file.read(before / name)[0], records)
    return entries, changes


def _report_history(file: Path, trends: Path | None) -> None:
    """Print the series whose level changed in the last nights, and draw all series."""
    entries, problems = record_file.read(file, Entry)
    complain(problems)
    result = history.series(entries)
    for name, entry in history.new_levels(result).items():
        click.echo(f"{name}: a new level since {entry.made} ({entry.commit_id}): {entry.value:.4g} {entry.unit}")
    if trends is not None:
        changes = {name: history.change_points([e.value for e in entries]) for name, entries in result.items()}
        write_trends(result, changes, trends)
