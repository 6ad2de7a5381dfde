"""Printing: JSON that never holds a NaN, numbers for people, and progress on stderr."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click
import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from cross_checks.records import lines as record_file
from cross_checks.records.record import Record

Report = Callable[[int, int, str], None]  # done, total, what comes next


def json_text(data: Any, indent: int | None = 2) -> str:
    """Return JSON; a number that is not finite becomes null."""
    return json.dumps(_plain(data), indent=indent, allow_nan=False)


def echo_json(data: Any, indent: int | None = 2) -> None:
    """Print JSON on stdout."""
    click.echo(json_text(data, indent))


def table(title: str, *columns: str) -> Table:
    """Return an empty table."""
    result = Table(title=title, title_justify="left", box=None, pad_edge=False, header_style="bold")
    for column in columns:
        result.add_column(column, overflow="fold")
    return result


def show(what: Any) -> None:
    """Print something for a person on stdout."""
    width = None if sys.stdout.isatty() else 160
    Console(file=sys.stdout, width=width, highlight=False, markup=False).print(what)


def number(value: float | None) -> str:
    """Return a number for a table; a dash where there is none."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.3g}"


@contextmanager
def progress(title: str) -> Iterator[Report]:
    """Show a bar on stderr where that is a terminal."""
    console = Console(file=sys.stderr)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(title, total=None)

        def report(done: int, total: int, what: str = "") -> None:
            bar.update(task, completed=done, total=total, description=f"{title} {what}".rstrip())

        yield report


def finite_record(record: Record) -> Record:
    """Return the record with None for every number that is not finite."""
    return record_file.from_dict(_plain(record.to_dict()))


def _plain(value: Any) -> Any:
    """Return what the JSON encoder takes."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
