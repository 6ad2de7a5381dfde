"""The report's plain companions: Markdown, CSV and JSON lines."""

from __future__ import annotations

import csv
import io
import json
from typing import Any

from cross_checks.records.record import Record
from reports.console import json_text
from reports.page.cheapest import TARGETS, entries, floor
from reports.page.command import command
from reports.page.findings import findings
from reports.page.numbers import ABSENT, duration, metres, setting
from reports.page.report_data import ReportData
from reports.page.sections.matrix import rows
from reports.page.sections.verdict import flagged, sentence

MISSED = ["not reached", ABSENT, ABSENT]


def jsonl(records: tuple[Record, ...]) -> str:
    """Return one line of JSON a record, everything in it."""
    return "".join(json_text(record.to_dict(), None) + "\n" for record in records)


def csv_table(records: tuple[Record, ...]) -> str:
    """Return one row a record: the figures without the histories. SI units; an empty field is not known."""
    out = io.StringIO()
    table = [csv_row(record) for record in records]
    writer = csv.DictWriter(out, fieldnames=list(table[0]) if table else ["scene"], lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return out.getvalue()


def csv_row(record: Record) -> dict[str, Any]:
    """Return a record's figures with the unit in each name."""
    error = record.error
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
        "error_m": error.value if error else None,
        "truth_uncertainty_m": error.uncertainty if error else None,
        "truth": error.truth if error else None,
        "compliance_position": record.measure("compliance_position"),
        "compliance_velocity": record.measure("compliance_velocity"),
        "energy_drift_J": record.measure("energy_drift"),
        **{f"{phase}": record.times.get(phase) for phase in ("build_s", "first_call_s", "loop_s")},
        "command": command(record),
    }


def markdown(data: ReportData) -> str:
    """Return the report's tables and sentences as Markdown."""
    parts = ["# mbs-ref: validation and benchmark report", sentence(data), *(f"- {text}" for text in flagged(data))]
    parts += ["## Validation matrix", _matrix(data)]
    parts += ["## Findings", *(f"- **{_plain(f.title)}.** {_plain(f.text)}" for f in findings(data))]
    parts += ["## Cost at equal error", *(_costs(data, scene) for scene in data.scenes if data.of_scene(scene))]
    parts += ["## Environment", _table(["what", "value"], [[k, v] for k, v in data.environment.items()])]
    return "\n\n".join(parts) + "\n"


def _matrix(data: ReportData) -> str:
    body = [[f"{row['engine']} {row['method']}", *(_cell(c) for c in row["cells"])] for row in rows(data)]
    return _table(["engine and method", *data.scenes], body)


def _cell(cell: dict[str, str]) -> str:
    return f"{cell['word']} ({cell['figure']})" if cell["tone"] != "plain" else cell["word"]


def _costs(data: ReportData, scene: str) -> str:
    body, records = [], data.of_scene(scene)
    for target in TARGETS:
        if target < floor(records):
            told = f"not ranked: the truth judges no error below {metres(floor(records))}"
            body.append([metres(target), told, *[ABSENT] * 3])
            continue
        for entry in entries(records, data.engines, target):
            best = entry.best
            cost = [best.method, setting(best.settings), duration(best.times["loop_s"])] if best else MISSED
            body.append([metres(target), entry.engine, *cost])
    return f"### {_plain(scene)}\n\n" + _table(["within", "engine", "method", "setting", "loop time"], body)


def _table(head: list[str], body: list[list[str]]) -> str:
    table = [head, ["---"] * len(head), *body]
    return "\n".join("| " + " | ".join(_plain(text) for text in row) + " |" for row in table)


def _plain(text: str) -> str:
    """Keep text from records from becoming markup."""
    return str(text).replace("&", "&amp;").replace("<", "&lt;").replace("|", "\\|").replace("\n", " ")
