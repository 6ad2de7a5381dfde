"""Build the report: query the store, compute what is missing, render and write the files; each whole or not at all.

Chromium without a window draws a page as a picture, prints it, or returns it with its plots drawn.
"""

import re
import shutil
import subprocess
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic

from cross_checks.records.lines import adapter
from mbs_ref.files import write_atomic
from reports.facts.report_data import ReportData
from reports.page.files import document, jsonl, record_columns
from reports.page.render import ALL, INDEX, render, single
from reports.poses_file import csv_table

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
LOADING_MS = 20_000  # ms of a page's own time until it is drawn
DRAWING = 600.0  # s that a browser may take


def browser() -> str | None:
    """Return the path of an installed browser, if there is one."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def drawn(address: str, option: str, *options: str) -> bytes:
    """Return the file that a browser's `option`, such as --screenshot, makes of a page.

    FileNotFoundError where no browser is installed.
    """
    with TemporaryDirectory() as folder:
        target = Path(folder) / "drawn.png"  # a screenshot has to end so, a print may
        loaded(address, *options, f"{option}={target}")
        return target.read_bytes()


def loaded(address: str, *options: str) -> bytes:
    """Return what a browser prints once it has drawn a page; FileNotFoundError where no browser is installed."""
    program = browser()
    if program is None:
        raise FileNotFoundError(f"no browser is installed; this needs one of {', '.join(BROWSERS)}")
    with TemporaryDirectory() as folder:
        fixed = ("--headless", "--no-sandbox", "--hide-scrollbars", f"--user-data-dir={folder}/profile")
        shown = (*fixed, f"--virtual-time-budget={LOADING_MS}", *options, address)
        return subprocess.run([program, *shown], check=True, capture_output=True, timeout=DRAWING).stdout


HTML = "html"
SCRIPTED = re.compile(rb"<(script|template|noscript)\b.*?</\1>", re.DOTALL)
LINK = re.compile(rb'href="([^"/:#]+\.html)(?:#[^"]*)?"')  # to another page, which is in the same file
PATIENCE = 10.0  # s between two pages at least
LEAST_APART = 20.0  # times the time that writing a page took: writing takes 5 % of the time at most


def write_report(
    out_dir: Path, stages: Generator[Callable[[], ReportData]], form: str = HTML, targets: Sequence[float] = ()
) -> tuple[Path, str]:
    """Write the pages of the last stage; before it, pages of what there is whenever they are due.

    Return the path of the report in the wanted form, and why it is incomplete or nothing.
    """
    due = monotonic() + PATIENCE
    for there in stages:
        begun = monotonic()
        if begun > due:
            try:
                write_data(data := there(), out_dir)
                publish(data, out_dir)
            except KeyboardInterrupt as stop:  # while verdicts come, `stages` ends with a sentence about it
                there = stages.throw(stop)
                break
            due = monotonic() + max(PATIENCE, LEAST_APART * (monotonic() - begun))
    data = there()
    write_data(data, out_dir)
    return publish(data.only(targets=targets), out_dir, form), data.incomplete


DATA = "report.json"


def write_data(data: ReportData, out_dir: Path) -> None:
    """Write what `read_data` reads."""
    out_dir.mkdir(parents=True, exist_ok=True)
    write_atomic(out_dir / DATA, adapter(ReportData).dump_json(data))


def publish(data: ReportData, out_dir: Path, form: str = HTML) -> Path:
    """Write a report in one of FORMS; return the path of its only or first file.

    FileNotFoundError where a form needs a browser and none is installed.
    """
    out_dir.mkdir(parents=True, exist_ok=True)
    contents = {name: make(data) for name, make in FORMS[form].items()} | (render(data) if form == HTML else {})
    for name, content in contents.items():
        write_atomic(out_dir / name, content)
    return out_dir / (INDEX if form == HTML else next(iter(contents)))


@contextmanager
def _address(data: ReportData) -> Iterator[str]:
    """Yield the address of one file that shows every page."""
    with TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        page.write_bytes(single(data))
        yield f"{page.as_uri()}#{ALL}"


def _pdf(data: ReportData) -> bytes:
    """Return every page in print."""
    with _address(data) as address:
        return drawn(address, "--print-to-pdf", "--no-pdf-header-footer")


def _static(data: ReportData) -> bytes:
    """Return every page as it is drawn, without scripts and, as in print, without what needs them."""
    with _address(data) as address:
        page = SCRIPTED.sub(b"", loaded(address, "--dump-dom", "--window-size=1400,1000"))
    return LINK.sub(rb'href="#\1"', page.replace(b"@media print", b"@media all"))


MARKDOWN = {"report.md": partial(document, template="report.md")}
TABLE = {"records.csv": lambda data: csv_table(record_columns(data.records)).encode()}
FORMS: dict[str, dict[str, Callable[[ReportData], bytes]]] = {  # each with the files beside the pages, or alone
    HTML: {"records.jsonl": lambda data: jsonl(data.records), **TABLE, **MARKDOWN},
    "single": {"report.html": single}, "static": {"static.html": _static}, "pdf": {"report.pdf": _pdf},
    "md": MARKDOWN, "csv": TABLE, "latex": {"report.tex": partial(document, template="report.tex.j2")},
}  # fmt: skip


def read_data(out_dir: Path) -> ReportData:
    """Return the data that a report left. FileNotFoundError where there are none; ValueError where they do not fit."""
    return data_of((out_dir / DATA).read_bytes())


def data_of(content: bytes) -> ReportData:
    """Return report data from JSON; ValueError where they do not fit."""
    return adapter(ReportData).validate_json(content)
