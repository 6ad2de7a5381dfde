"""Make the report: run, judge, render, and write each file whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mbs_ref.atomic import write_atomic
from reports.page.files import csv_table, jsonl, markdown
from reports.page.gather import gather
from reports.page.render import render
from reports.page.report_data import ReportData


def write_report(out_dir: Path, quick: bool = False, progress: Any = None) -> Path:
    """Run the default scenes on every engine and write the report; return the path of index.html.

    `quick` runs fewer scenes and settings. `progress` is called with (done, total, text) or is None.
    """
    return publish(gather(quick, progress), Path(out_dir))


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
