"""mbs-ref symmetry: does each engine move a scene's image as it moves the scene?"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from mbs_ref.atomic_file import write_atomic
from reports import inputs
from reports.terminal.console import echo_json, progress, show, table
from reports.terminal.exit_codes import Failed, Incomplete, NothingSelected


@click.command(name="symmetry")
@inputs.ENGINES
@click.option("--only", metavar="TEXT", help="Only cases whose engine, method and scene hold this.")
@click.option("--table", "target", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
              help="Write what was found as JSON: the page shows benchmarks/symmetry.json.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(chosen: tuple[str, ...], only: str | None, target: Path | None, as_json: bool) -> None:
    """Turn, mirror, shift, rescale, reorder, rename scenes, cut runs in two and run them back: the motion must follow.

    Every method of every engine, each case in a process of its own. Exit code 1 where the reference solver breaks a
    symmetry by more than roundoff and its own error; other engines' violations are findings.
    """
    from cross_checks.conformance.cases import cases
    from cross_checks.conformance.symmetry import survey
    from cross_checks.isolation.parent import Isolated

    asked = [case for case in cases(inputs.engine_names(chosen)) if only is None or only in case.name]
    if not asked:
        raise NothingSelected(f"no case of these engines is named like {only!r}")
    found: list[dict[str, Any]] = []
    try:
        with progress("symmetry") as report, Isolated() as call:
            for case in asked:
                report(len(found), len(asked), case.name)
                found.append(survey.isolated(case, call))
    except KeyboardInterrupt:
        raise Incomplete(f"interrupted after {len(found)} cases") from None
    facts = {"methods": survey.by_method(found), "cases": found}
    if target:
        write_atomic(target, (json.dumps(facts, indent=1, allow_nan=False) + "\n").encode())
    if as_json:
        echo_json(facts)
    else:
        _show(facts)
    ours = [one for one in found if one["engine"] == "mbs_ref" and any(x["exceeds_error"] for x in one["broken"])]
    if ours:
        raise Failed("mbs_ref breaks a symmetry: " + ", ".join(f"{one['method']} on {one['scene']}" for one in ours))


def _show(facts: dict[str, Any]) -> None:
    words = ("engine", "method", "scenes", "not finished", "judged", "beyond roundoff", "beyond its error")
    listing = table("Symmetries", *words)
    for row in facts["methods"]:
        figures = ("cases", "stopped", "judged", "broken", "beyond_error")
        listing.add_row(row["engine"], row["method"], *(str(row[key]) for key in figures))
    show(listing)
    words = ("engine", "method", "scene", "symmetry", "by, m", "roundoff, m", "error, m")
    listing = table("\nBroken beyond roundoff", *words)
    for one in facts["cases"]:
        for each in one["broken"]:
            sizes = (f"{each[key]:.1e}" for key in ("size", "noise", "error"))
            listing.add_row(one["engine"], one["method"], one["scene"], each["symmetry"], *sizes)
        if one["stopped"]:
            listing.add_row(one["engine"], one["method"], one["scene"], one["stopped"], "", "", "")
    show(listing)
