"""mbs-ref symmetry: does each engine move a scene's image as it moves the scene?"""

from pathlib import Path
from typing import Any

import click

from reports import inputs
from reports.console import ONLY, Failed, answer, interruptible, named, progress, show_table, table_file


@click.command(name="symmetry", epilog="Example: mbs-ref symmetry")
@inputs.ENGINES
@ONLY
@table_file("symmetry")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def command(chosen: tuple[str, ...], only: str | None, target: Path | None, as_json: bool) -> None:
    """Transform scenes; the motions must follow.

    They are turned, mirrored, shifted, rescaled, reordered, renamed, cut in two and run back.
    Every method of every engine, each case in a process of its own. Exit code 1 where the reference solver breaks a
    symmetry by more than roundoff and its own error; other engines' violations are findings.
    """
    from cross_checks.conformance.cases import cases
    from cross_checks.conformance.symmetry import by_method, isolated
    from cross_checks.isolation.parent import Isolated

    wanted = named(cases(inputs.engine_names(chosen)), only)
    result: list[dict[str, Any]] = []
    with interruptible(lambda: f"{len(result)} cases"), progress("symmetry") as report, Isolated() as call:
        for case in wanted:
            report(len(result), len(wanted), case.name)
            result.append(isolated(case, call))
    facts = {"methods": by_method(result), "cases": result}
    answer(facts, target, as_json, _show)
    ours = [one for one in result if one["engine"] == "mbs_ref" and any(x["exceeds_error"] for x in one["broken"])]
    if ours:
        raise Failed("mbs_ref breaks a symmetry: " + ", ".join(f"{one['method']} on {one['scene']}" for one in ours))


def _show(facts: dict[str, Any]) -> None:
    words = ("engine", "method", "scenes", "not finished", "judged", "beyond roundoff", "beyond its error")
    keys = ("engine", "method", "cases", "stopped", "judged", "broken", "beyond_error")
    show_table("Symmetries", words, ([row[key] for key in keys] for row in facts["methods"]))
    words = ("engine", "method", "scene", "symmetry", "by, m", "roundoff, m", "error, m")
    rows = []
    for one in facts["cases"]:
        about = (one["engine"], one["method"], one["scene"])
        for each in one["broken"]:
            rows.append((*about, each["symmetry"], *(f"{each[key]:.1e}" for key in ("size", "noise", "error"))))
        rows += [(*about, one["stopped"])] if one["stopped"] else []
    show_table("\nBroken beyond roundoff", words, rows)
