"""Make the report: run, judge, render and write."""

from __future__ import annotations

from pathlib import Path

from reports.page.gather import Progress, gather
from reports.page.publish import publish

EXTREMES = "extremes.jsonl"  # beside the page: what `mbs-ref extremes -o` kept


def write_report(out_dir: Path, quick: bool = False, progress: Progress | None = None) -> tuple[Path, str]:
    """Run the default scenes on every engine and write the report.

    Return the path of index.html, and why it is incomplete or nothing. `quick` runs fewer scenes. What EXTREMES
    holds there is shown, else a few extremes are run. `progress` is called with (done, total, what comes next).
    """
    data = gather(quick, progress, Path(out_dir) / EXTREMES)
    return publish(data, Path(out_dir)), data.incomplete
