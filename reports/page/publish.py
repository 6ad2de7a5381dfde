"""Write the report's files, each whole or not at all."""

from __future__ import annotations

from pathlib import Path

from mbs_ref.atomic_file import write_atomic
from reports.page.files import csv_table, jsonl, markdown
from reports.page.render import render
from reports.page.report_data import ReportData


def publish(data: ReportData, out_dir: Path) -> Path:
    """Write index.html, report.md, records.csv and records.jsonl; return the path of index.html."""
    contents = {
        "records.jsonl": jsonl(data.records),
        "records.csv": csv_table(data.records),
        "report.md": markdown(data),
        "index.html": render(data),
    }
    out_dir.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        write_atomic(out_dir / name, content.encode())
    return out_dir / "index.html"
