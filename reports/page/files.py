"""The report's plain companions: Markdown, CSV and JSON lines."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable
from typing import Any

from cross_checks import metrics
from cross_checks.metrics import component_errors
from cross_checks.records.cost import is_busy
from cross_checks.records.numbers import ABSENT, setting
from cross_checks.records.record import Record
from reports.facts.report_data import ReportData
from reports.facts.stored import adapter
from reports.page.advice import Advice, advice
from reports.page.findings import findings
from reports.page.sections.decisions import counted
from reports.page.sections.matrix import view
from reports.page.sections.prices import price_table
from reports.page.slug import command

TIMES = ("build_s", "first_call_s", "loop_s", "loop_median_s", "loop_most_s", "loop_runs")
VERDICTS = {
    "engine": "engine",
    "method": "method",
    "verdict": "word",
    "code": "code",
    "error": "error",
    "setting": "setting",
    "why": "reason",
}  # column -> key of a cell's view
PRICES = ("within", "engine", "method", "setting", "error", "loop time", "over the cheapest")


def jsonl(records: tuple[Record, ...]) -> bytes:
    """Return one line of JSON a record, everything in it."""
    return b"".join(adapter(Record).dump_json(record) + b"\n" for record in records)


def csv_table(records: tuple[Record, ...]) -> str:
    """Return one row a record: the figures without the histories. SI units; an empty field is not known."""
    out = io.StringIO()
    table = [csv_row(record) for record in records]
    writer = csv.DictWriter(out, fieldnames=list(table[0]) if table else ["scene"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return out.getvalue()


def parquet(records: Iterable[Record]) -> bytes:
    """Return the rows of `csv_table` as a Parquet file; ImportError where pyarrow is not installed."""
    import pyarrow  # pyright: ignore[reportMissingImports]  # an optional extra
    import pyarrow.parquet  # pyright: ignore[reportMissingImports]

    out = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.Table.from_pylist([csv_row(record) for record in records]), out)
    return out.getvalue()


def csv_row(record: Record) -> dict[str, Any]:
    """Return a record's figures with the unit in each name; every metric has a column."""
    error = record.error
    units = {name: metric.unit for name, metric in metrics.every().items()}
    return {
        "scene": record.scene,
        "parameters": json.dumps(record.parameters),
        "engine": record.engine,
        "method": record.method,
        "setting": setting(record.settings),
        "status": record.status,
        "message": record.message,
        "t_end_s": record.t_end,
        "steps": record.steps,
        "rhs_calls": record.rhs_calls,
        "error": error.value if error else None,
        "error_m": error.metres if error else None,
        "error_worst": error.worst if error else None,
        "truth_uncertainty": error.uncertainty if error else None,
        "truth": error.truth if error else None,
        **{f"{name} [{unit}]": record.measure(name) for name, unit in units.items()},
        **{f"{error.name} below [{error.unit}]": record.bounds.get(error.name) for error in component_errors.METRICS},
        **{phase: record.times.get(phase) for phase in TIMES},
        "busy": is_busy(record),
        "command": command(record),
    }


def markdown(data: ReportData) -> str:
    """Return the report's tables and sentences as Markdown."""
    parts = ["# mbs-ref: validation and benchmark report", counted(data), "## Engines"]
    parts += [f"- **{_plain(line.engine)}**: {_plain(_advice(line))}" for line in advice(data)]
    parts += ["## Cost at equal error", *(price_text(data, scene) for scene in data.scenes)]
    parts += ["## Verdicts", *(verdict_text(data, scene) for scene in data.scenes)]
    parts += ["## Findings", *(f"- **{_plain(f.title)}.** {_plain(f.text)}" for f in findings(data))]
    parts += ["## Environment", _table(["what", "value"], [[k, v] for k, v in data.environment.items()])]
    return "\n\n".join(parts) + "\n"


def _advice(line: Advice) -> str:
    silent = f"Wrong with success reported: {'; '.join(line.silent)}." if line.silent else ""
    pace = f"{line.pace}." if line.pace else ""
    return " ".join(part for part in (line.use, line.reach, silent, line.limit, pace) if part)


def price_text(data: ReportData, scene: str) -> str:
    """Return a scene's cost at equal error as a Markdown table."""
    body = [price_row(block["target"], row) for block in price_table(data, scene) for row in block["rows"]]
    return f"### {_plain(scene)}\n\n" + _table(list(PRICES), body)


def price_row(target: str, row: dict[str, Any]) -> list[str]:
    """Return a row of cost at equal error: target, engine, and what it takes or why not."""
    if row["missed"]:
        return [target, row["engine"], row["missed"], *[ABSENT] * 4]
    return [target, row["engine"], row["method"], row["setting"], row["error"], row["time"], row["factor"]]


def verdict_text(data: ReportData, scene: str) -> str:
    """Return a scene's verdicts as a Markdown table."""
    cells = [view(cell) for cell in data.cells if cell.label == scene]
    body = [[str(c[key]) for key in VERDICTS.values()] for c in cells]
    return f"### {_plain(scene)}\n\n" + _table(list(VERDICTS), body)


def _table(head: list[str], body: list[list[str]]) -> str:
    table = [head, ["---"] * len(head), *body]
    return "\n".join("| " + " | ".join(_plain(text) for text in row) + " |" for row in table)


def _plain(text: str) -> str:
    """Keep text from records from becoming markup."""
    return str(text).replace("&", "&amp;").replace("<", "&lt;").replace("|", "\\|").replace("\n", " ")
