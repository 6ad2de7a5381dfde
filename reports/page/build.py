"""Build the report: query the store, compute what is missing, render and write the files; each whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from time import monotonic

from mbs_ref.atomic_file import write_atomic
from reports.facts.report_data import ReportData
from reports.facts.stored import adapter
from reports.page.files import csv_table, jsonl, markdown
from reports.page.render import INDEX, render

PATIENCE = 10.0  # s after which a page of what there is is worth the time to write it


def write_report(out_dir: Path, stages: Iterator[ReportData]) -> tuple[Path, str]:
    """Write the pages of the last stage; where stages take long, also what there is before the next one begins.

    Return the path of index.html, and why it is incomplete or nothing.
    """
    shown = monotonic()
    for data in stages:
        if monotonic() > shown + PATIENCE:
            publish(data, out_dir)
            shown = monotonic()
    return publish(data, out_dir), data.incomplete


def render_again(out_dir: Path) -> tuple[Path, str]:
    """Render the data that the last report left, and simulate nothing. FileNotFoundError where there are none."""
    data = read_data(out_dir)
    return publish(data, out_dir), data.incomplete


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
    """Return report data from JSON; ValueError where they do not fit."""
    return adapter(ReportData).validate_json(content)
