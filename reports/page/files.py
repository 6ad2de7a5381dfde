"""The report's plain companions: Markdown, CSV and JSON lines."""

import json
from collections.abc import Iterable
from typing import Any

from cross_checks import metrics
from cross_checks.metrics.errors import COMPONENTS
from cross_checks.records.lines import adapter
from cross_checks.records.numbers import ABSENT, setting
from cross_checks.records.record import Record, is_busy
from reports.facts.report_data import ReportData
from reports.page.advice import advice
from reports.page.findings import findings
from reports.page.render import templates
from reports.page.sections.matrix import view
from reports.page.sections.overview import counted
from reports.page.sections.prices import cannot, price_table
from reports.page.slug import command

TIMES = ("build_s", "first_call_s", "loop_s", "loop_median_s", "loop_most_s", "loop_runs")
VERDICTS = {
    "engine": "engine", "method": "method", "verdict": "word", "code": "code", "error": "error", "setting": "setting",
    "why": "reason",
}  # column -> key of a cell's view  # fmt: skip
PRICES = ("within", "engine", "method", "setting", "error", "loop time", "over the cheapest")


def jsonl(records: tuple[Record, ...]) -> bytes:
    """Return one line of JSON a record, everything in it."""
    return b"".join(adapter(Record).dump_json(record) + b"\n" for record in records)


def record_columns(records: Iterable[Record]) -> dict[str, list[Any]]:
    """Return the figures of records without the histories, by column. SI units; None where a figure is unknown."""
    table = [csv_row(record) for record in records]
    return {name: [row[name] for row in table] for name in (table[0] if table else ("scene",))}


def csv_row(record: Record) -> dict[str, Any]:
    """Return a record's figures with the unit in each name; every metric has a column."""
    error = record.error
    units = {name: metric.unit for name, metric in metrics.every().items()}
    return {
        "scene": record.scene, "parameters": json.dumps(record.parameters), "engine": record.engine,
        "method": record.method, "setting": setting(record.settings), "status": record.status,
        "message": record.message, "t_end_s": record.t_end, "steps": record.steps, "rhs_calls": record.rhs_calls,
        "error": error.value if error else None, "error_m": error.metres if error else None,
        "error_worst": error.worst if error else None, "truth_uncertainty": error.uncertainty if error else None,
        "truth": error.truth if error else None,
        **{f"{name} [{unit}]": record.measure(name) for name, unit in units.items()},
        **{f"{error.name} below [{error.unit}]": record.bounds.get(error.name) for error in COMPONENTS},
        **{phase: record.times.get(phase) for phase in TIMES}, "busy": is_busy(record), "command": command(record),
    }  # fmt: skip


def document(data: ReportData, template: str) -> bytes:
    """Return the report's tables and sentences in the form of a template."""
    shown = [cell for cell in data.cells if cell.engine not in data.missing]
    views = {scene: [view(cell) for cell in shown if cell.label == scene] for scene in data.scenes}
    context = {
        "counted": counted(data), "missing": sorted(data.missing), "advice": advice(data), "findings": findings(data),
        "environment": data.environment, "price_head": PRICES, "verdict_head": VERDICTS,
        "prices": {scene: price_rows(data, scene) for scene in data.scenes},
        "verdicts": {scene: [[one[key] for key in VERDICTS.values()] for one in own] for scene, own in views.items()},
    }  # fmt: skip
    return templates().get_template(template).render(context).encode() + b"\n"


def price_rows(data: ReportData, scene: str) -> list[list[str]]:
    """Return the rows of cost at equal error on a scene, without engines that run it at no target."""
    blocks = price_table(data, scene)
    never = cannot(blocks)
    return [price_row(b["target"], row) for b in blocks for row in b["rows"] if row["engine"] not in never]


def price_row(target: str, row: dict[str, Any]) -> list[str]:
    """Return a row of cost at equal error: target, engine, and what it takes or why not."""
    if row["missed"]:
        return [target, row["engine"], row["missed"], *[ABSENT] * 4]
    return [target, row["engine"], row["method"], row["setting"], row["error"], row["time"], row["factor"]]
