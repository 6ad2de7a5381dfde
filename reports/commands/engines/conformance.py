"""mbs-ref conformance: the whole validation of somebody's solver, from its adapter file."""

import json
import sys
from pathlib import Path

import click

from cross_checks.conformance.finding import Report
from reports import inputs
from reports.console import Failed, number, show_table

HEAD = ("scene", "method", "order", "documented", "error", "loop, s")


@click.command(name="conformance", epilog="Example: mbs-ref conformance small_.py")
@click.argument("engine", metavar="ADAPTER.py|ENGINE", default="mbs_ref")
@click.option("--json", "file", type=inputs.NEW_FILE, help="also write all findings here")
@click.option("--badge", type=inputs.NEW_FILE, help="also write a shields.io endpoint here")
@click.option("--timeout", type=inputs.POSITIVE, metavar="S", help="s that one run may compute or sleep  [default: 60]")
@click.option("--self-test", is_flag=True, help="examine copies of mbs_ref with one mistake each instead")
def command(engine: str, file: Path | None, badge: Path | None, timeout: float | None, self_test: bool) -> None:
    """Examine a solver by the requirements of every engine.

    That is refusals, times, velocities, clock, order, truths, energy, joints, and how it fails.
    ADAPTER.py holds a subclass of cross_checks.engine.Engine and the line ENGINE = <that class>. Errors are relative
    to each scene's size (in rad for orientations); a failure that the method declares as its weakness is named and
    does not count. Every run has a process of its own: one that hangs or dies is named, and the others continue.
    """
    from cross_checks.conformance.apart import TIMEOUT, Apart
    from cross_checks.conformance.examine import examine
    from cross_checks.conformance.loading import name_of
    from cross_checks.isolation.parent import Isolated

    if self_test:
        _self_test()
        return
    examined = inputs.engine(engine)
    with Isolated(TIMEOUT if timeout is None else timeout) as ask:
        report = examine(Apart(examined, ask), name_of(engine), _progress)
    if file is not None:
        file.write_text(json.dumps(report.to_dict(), indent=1))
    if badge is not None:
        badge.write_text(json.dumps(_badge(report)))
    _show(report)
    if not report.conforms:
        raise Failed(f"{engine} fails the examination; the lines above that begin with FAILED state why")


def _progress(text: str) -> None:
    if not sys.stderr.isatty():
        return
    click.echo(f"\r{text:<60}", nl=False, err=True)


def _show(report: Report) -> None:
    """Print the table of figures, what is exempt, what failed, and the sum."""
    rows = ((r.scene, r.method, *map(number, (r.order, r.documented, r.error, r.loop_s))) for r in report.rows)
    show_table(f"{report.engine} {report.version}", HEAD, rows)
    for finding in report.of("exempt"):
        click.echo(f"exempt: {finding.question}: {finding.scene} by {finding.method}: {finding.detail}")
    for method, exemption in sorted({(f.method, f.exemption) for f in report.of("exempt")}):
        click.echo(f"  {method} declares: {exemption}")
    for finding in report.of("failed"):
        click.echo(f"FAILED: {finding.question}: {finding.scene} {finding.method}: {finding.detail}")
    if report.uncovered:
        click.echo(f"declared, and in none of the scenes: {', '.join(report.uncovered)}")
    click.echo(", ".join(f"{count} {outcome}" for outcome, count in _counts(report).items()))


def _counts(report: Report) -> dict[str, int]:
    return {outcome: len(report.of(outcome)) for outcome in ("passed", "exempt", "failed")}


def _badge(report: Report) -> dict[str, object]:
    """Return a badge in the form that shields.io reads from an endpoint."""
    counts = _counts(report)
    message = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count)
    colour = "red" if counts["failed"] else "yellow" if counts["exempt"] else "brightgreen"
    return {"schemaVersion": 1, "label": "mbs-ref conformance", "message": message, "color": colour}


def _self_test() -> None:
    """Print how each mistake is noticed, the detection rate, and false alarms."""
    from cross_checks import engines
    from cross_checks.conformance.broken_engines import self_test
    from cross_checks.conformance.examine import examine

    false, caught, wanted = (), 0, 0
    for result in self_test(engines.get("mbs_ref"), examine):
        click.echo(f"{result.mistake:<40} {', '.join(result.by) or 'nothing noticed'}")
        if not result.applies:
            false = result.by
            continue
        wanted, caught = wanted + 1, caught + bool(set(result.by) - set(false))
    click.echo(f"{caught} of {wanted} mistakes noticed, {len(false)} false alarms")
    if false or caught < wanted:
        raise Failed("the examination misses mistakes, or reports some that are none")
