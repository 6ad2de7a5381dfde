"""What the commands share that ask one question of every method of every engine: options, and how they answer."""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import click

from mbs_ref.atomic_file import write_atomic
from reports.terminal.console import NothingSelected, echo_json

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


def answer(facts: dict[str, Any], target: Path | None, as_json: bool, draw: Callable[[dict[str, Any]], None]) -> None:
    """Write the facts to a file where one is asked for, and print them as JSON or as `draw` does."""
    if target:
        write_table(facts, target)
    if as_json:
        echo_json(facts)
    else:
        draw(facts)


def write_table(facts: dict[str, Any], target: Path) -> None:
    """Write what the page shows as JSON; ValueError where a number is not finite."""
    write_atomic(target, (json.dumps(facts, indent=1, allow_nan=False) + "\n").encode())
