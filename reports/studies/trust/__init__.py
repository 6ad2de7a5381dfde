"""The tables that `mbs-ref calibrate`, `symmetry` and `repeatability` write with --table, as they stand in the tree."""

from typing import Any

from mbs_ref.files import package_data
from reports.facts.curves import Measured, Row

ABOUT = ("engine", "method", "scene")


def measure() -> Measured:
    """Read the tables; nothing is computed."""
    calibration, symmetry, repeatability = map(table, ("calibration", "symmetry", "repeatability"))
    every = calibration["table"][0]
    figures = {f"calibration.{name}": every[name] for name in ("judged", "below", "overestimate_median")}
    tables = {
        "calibration": calibration["table"], "below": calibration["below"], "symmetry": symmetry["methods"],
        "violations": [row for case in symmetry["cases"] for row in _violations(case)],
        "repeatability": [_repeated(row) for row in repeatability["methods"]],
    }  # fmt: skip
    figures |= {"calibration.runs": calibration["runs"], "calibration.first": calibration["first"]}
    return Measured(figures, {name: tuple(rows) for name, rows in tables.items()})


def table(name: str) -> dict[str, Any]:
    """Return what a command wrote."""
    return package_data("benchmarks", f"{name}.json")


def _violations(case: dict[str, Any]) -> list[Row]:
    """Return a row for each symmetry that a case violates, and one for a case that did not finish."""
    about = {name: case[name] for name in ABOUT}
    rows = [about | {name: one[name] for name in ("symmetry", "size", "noise", "error")} for one in case["broken"]]
    unfinished = about | {"symmetry": case["stopped"], "size": "", "noise": "", "error": ""}
    return [*rows, *([unfinished] if case["stopped"] else [])]


def _repeated(row: dict[str, Any]) -> Row:
    """Return for each way of repeating how many runs differ, and by how much."""
    ways = {
        way["way"]: f"{way['differ']}: {way['largest'] or 0.0:.3g}" if way["differ"] else "none" for way in row["ways"]
    }
    return {name: row[name] for name in ("engine", "method", "runs")} | ways
