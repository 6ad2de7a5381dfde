"""Make the report: run, judge, render and write."""

from __future__ import annotations

from pathlib import Path

from reports.page.gather import Progress, gather
from reports.page.publish import publish


def write_report(out_dir: Path, quick: bool = False, progress: Progress | None = None) -> Path:
    """Run the default scenes on every engine and write the report; return the path of index.html.

    `quick` runs fewer scenes. `progress` is called with (done, total, what comes next).
    """
    return publish(gather(quick, progress), Path(out_dir))
