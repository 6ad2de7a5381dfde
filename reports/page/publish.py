"""Write the report's files, each whole or not at all, and its data, from which it can be rendered again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from mbs_ref.atomic_file import write_atomic
from reports.facts.kept import adapter
from reports.facts.report_data import ReportData
from reports.page.files import csv_table, jsonl, markdown
from reports.page.pages import INDEX
from reports.page.render import render
from reports.studies.study import every

DATA = "report.json"


def publish(data: ReportData, out_dir: Path) -> Path:
    """Write the pages and, beside them, the data as JSON, CSV and Markdown; return the path of the first page."""
    contents = {
        DATA: adapter(ReportData).dump_json(data),
        "records.jsonl": jsonl(data.records),
        "records.csv": csv_table(data.records).encode(),
        "report.md": markdown(data).encode(),
    }
    out_dir.mkdir(parents=True, exist_ok=True)
    for name, content in (contents | render(data)).items():
        write_atomic(out_dir / name, content)
    return out_dir / INDEX


def read_data(out_dir: Path) -> ReportData:
    """Return the data that a report left. FileNotFoundError where there are none; ValueError where they do not fit."""
    return data_of((out_dir / DATA).read_bytes())


def data_of(content: bytes) -> ReportData:
    """Return report data from JSON, each study's facts as its own type; ValueError where they do not fit."""
    data = adapter(ReportData).validate_json(content)
    kinds = {name: adapter(study.facts) for name, study in every().items() if name in data.studies}
    return replace(data, studies={name: kind.validate_python(data.studies[name]) for name, kind in kinds.items()})
