"""What a person at a terminal reads and answers: colours, progress, questions, exit codes, plots in characters.

JSON without NaN, numbers and tables for people go to stdout, progress to stderr.
"""

import json
import math
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import ArrayLike
from pydantic_core import to_json
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from cross_checks.records.lines import adapter
from cross_checks.records.record import Record
from mbs_ref.files import write_atomic

EVERY = 3.0  # s between lines of progress in a log
PAUSE = 1.0  # s that nobody minds to wait

Report = Callable[[int, int, str], None]  # done, total, what comes next


def json_text(data: Any, indent: int | None = 2) -> str:
    """Return JSON of plain data, arrays and dataclasses; a number that is not finite becomes null."""
    return to_json(data, indent=indent, inf_nan_mode="null", fallback=lambda array: array.tolist()).decode()


def echo_json(data: Any, indent: int | None = 2) -> None:
    """Print JSON on stdout."""
    click.echo(json_text(data, indent))


def table(title: str, *columns: str) -> Table:
    """Return an empty table."""
    result = Table(title=title, title_justify="left", box=None, pad_edge=False, header_style="bold")
    for column in columns:
        result.add_column(column, overflow="fold")
    return result


def show_table(title: str, columns: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Print a table of texts on stdout."""
    listing = table(title, *columns)
    for row in rows:
        listing.add_row(*map(str, row))
    show(listing)


def show(what: Any) -> None:
    """Print something for a person on stdout."""
    width = None if sys.stdout.isatty() else 160
    Console(file=sys.stdout, width=width, highlight=False, markup=False).print(what)
    sys.stdout.flush()  # what is known is seen, though more is awaited


def number(value: float | None) -> str:
    """Return a number for a table; a dash where there is none."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.3g}"


def amount(value: float | None, unit: str, below: float | None = None) -> str:
    """Return a number with its unit; where it is unknown, what it is at most; empty where that is unknown, too."""
    if value is None:
        return "" if below is None else f"below {number(below)} {unit}"
    return f"{number(value)} {unit}"


@contextmanager
def progress(title: str) -> Iterator[Report]:
    """Show a bar on stderr; where that is no terminal, a line every EVERY seconds."""
    if not sys.stderr.isatty():
        yield Lines(title)
        return
    console = Console(file=sys.stderr)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None)

        def report(done: int, total: int, what: str = "") -> None:
            bar.update(task, completed=done, total=total, description=f"{title} {what}".rstrip())

        yield report


def complain(problems: Iterable[str]) -> None:
    """Print sentences on stderr."""
    for problem in problems:
        click.echo(problem, err=True)


@contextmanager
def reported_as(kind: type[click.ClickException], *errors: type[Exception]) -> Iterator[None]:
    """Raise an exception of `kind`, with the same sentence, in place of one of `errors`."""
    try:
        yield
    except errors as error:
        raise kind(str(error)) from error


@contextmanager
def interruptible(done: Callable[[], str]) -> Iterator[None]:
    """Raise Incomplete on Ctrl-C, with what is done."""
    try:
        yield
    except KeyboardInterrupt:
        raise Incomplete(f"interrupted after {done()}") from None


@contextmanager
def awaited(what: str) -> Iterator[None]:
    """Print on stderr what is awaited, once it has taken longer than PAUSE."""
    clock = threading.Timer(PAUSE, click.echo, [f"{what} ..."], {"err": True})
    clock.start()
    try:
        yield
    finally:
        clock.cancel()


@contextmanager
def compiling() -> Iterator[None]:
    """Print on stderr, once, that the solver is being compiled, which takes minutes."""
    from cross_checks.isolation.messages import compiling_reported

    stated: list[bool] = []

    def begins() -> None:
        if not stated:
            stated.append(True)
            click.echo("compiling the solver, once on this machine: a minute or two ...", err=True)

    with compiling_reported(begins, lambda: None):
        yield


class Lines:
    """Progress for a log: done of how many, the time so far, and what is under way."""

    def __init__(self, title: str) -> None:
        self.title, self.begun = title, time.monotonic()
        self.shown = self.begun

    def __call__(self, done: int, total: int, what: str = "") -> None:
        now = time.monotonic()
        if now - self.shown >= EVERY:
            self.shown = now
            click.echo(f"{self.title}: {done}/{total} after {now - self.begun:.0f} s {what}".rstrip(), err=True)


def finite_record(record: Record) -> Record:
    """Return the record with None for every number that is not finite."""
    return adapter(Record).validate_json(json_text(record.to_dict()))


class Failed(click.ClickException):
    """A validation or regression failed."""

    exit_code = 1


class EngineAbsent(click.ClickException):
    """An engine that was requested by name is not installed."""

    exit_code = 3


class Incomplete(click.ClickException):
    """The work was interrupted; what was computed is stored."""

    exit_code = 4


class NothingSelected(click.ClickException):
    """No scene, engine, method or setting fits the request."""

    exit_code = 5


class Defect(click.ClickException):
    """An error that no input should cause."""

    exit_code = 6


TABLE = "\b\n" + (files(__package__) / "exit_codes.txt").read_text(encoding="utf-8")  # as click leaves it


ONLY = click.option("--only", metavar="TEXT", help="Only cases whose engine, method and scene hold this.")


def table_file(name: str) -> Callable:
    """Return the option of a file for the table that the page shows as benchmarks/<name>.json."""
    return click.option(
        "--table", "target", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
        help=f"Write the results as JSON: the page shows benchmarks/{name}.json.",
    )  # fmt: skip


def named[Case](cases: Iterable[Case], only: str | None) -> list[Case]:
    """Return the cases whose name holds the text; NothingSelected where none does."""
    wanted = [case for case in cases if only is None or only in case.name]  # type: ignore[attr-defined]
    if not wanted:
        raise NothingSelected(f"no case of these engines is named like {only!r}")
    return wanted


def answer(facts: Any, target: Path | None, as_json: bool, draw: Callable[[Any], None]) -> None:
    """Write the facts to a file where one is named, and print them as JSON or as `draw` does."""
    if target:
        write_table(facts, target)
    if as_json:
        echo_json(facts)
    else:
        draw(facts)


def write_table(facts: dict[str, Any], target: Path) -> None:
    """Write what the page shows as JSON; ValueError where a number is not finite."""
    write_atomic(target, (json.dumps(facts, indent=1, allow_nan=False) + "\n").encode())


WIDTH, HEIGHT = 72, 16  # characters of the field
MARKS = "ox+*#@%&"


def text_plot(
    lines: Mapping[str, tuple[ArrayLike, ArrayLike]], x_label: str, y_label: str,
    log_x: bool = False, log_y: bool = False,
) -> str:  # fmt: skip
    """Return a plot of every line's (x, y), each with a mark of its own; empty where there is nothing to draw.

    Points that are not finite, or not positive on a logarithmic axis, are left out.
    """
    points = {name: _on_axes(*line, log_x, log_y) for name, line in lines.items()}
    points = {name: line for name, line in points.items() if len(line)}
    if not points:
        return ""
    every = np.concatenate(list(points.values()))
    low, high = every.min(axis=0), every.max(axis=0)
    span = np.where(high > low, high - low, 1.0)
    field = [[" "] * WIDTH for _ in range(HEIGHT)]
    for mark, line in zip(_marks(len(points)), points.values(), strict=True):
        columns, rows = np.round((line - low) / span * (WIDTH - 1, HEIGHT - 1)).astype(int).T
        for column, row in zip(columns, rows, strict=True):
            field[HEIGHT - 1 - row][column] = mark
    return "\n".join(_framed(field, _ends(low, high, 1, log_y), _ends(low, high, 0, log_x), x_label, y_label, points))


def _on_axes(x: ArrayLike, y: ArrayLike, log_x: bool, log_y: bool) -> np.ndarray:
    """Return the points (n, 2) that can be drawn, in the axes' own measure."""
    with np.errstate(divide="ignore", invalid="ignore"):
        columns = [np.log10(v) if log else np.asarray(v, float) for v, log in ((x, log_x), (y, log_y))]
    result = np.column_stack(columns)
    return result[np.all(np.isfinite(result), axis=1)]


def _marks(number: int) -> str:
    return (MARKS * (number // len(MARKS) + 1))[:number]


def _ends(low: np.ndarray, high: np.ndarray, axis: int, log: bool) -> tuple[str, str]:
    ends = (low[axis], high[axis])
    return tuple(f"{10.0**end if log else end:.3g}" for end in ends)  # type: ignore[return-value]


def _framed(
    field: list[list[str]], y_ends: tuple[str, str], x_ends: tuple[str, str], x_label: str, y_label: str,
    names: Mapping[str, object],
) -> list[str]:  # fmt: skip
    """Return the field with axes, their ends and the legend."""
    margin = max(len(end) for end in y_ends)
    sides = [y_ends[1], *[""] * (len(field) - 2), y_ends[0]]
    rows = [f"{side:>{margin}} |{''.join(row).rstrip()}" for side, row in zip(sides, field, strict=True)]
    axis = f"{'':>{margin}} +{'-' * WIDTH}"
    ends = f"{'':>{margin}}  {x_ends[0]}{x_ends[1]:>{WIDTH - len(x_ends[0])}}"
    legend = "   ".join(f"{mark} {name}" for mark, name in zip(_marks(len(names)), names, strict=True))
    return [y_label, *rows, axis, ends, f"{'':>{margin}}  {x_label}", f"{'':>{margin}}  {legend}"]
