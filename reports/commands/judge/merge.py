"""mbs-ref merge: join stores of runs."""

from __future__ import annotations

from pathlib import Path

import click

from cross_checks.records.store import Store, default_path
from reports.query import STORE

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.command(name="merge")
@click.argument("others", nargs=-1, required=True, type=FILE, metavar="FILE.sqlite...")
@STORE
def command(others: tuple[Path, ...], store: str | None) -> None:
    """Add the runs of other stores (shards, other machines) to the store."""
    with Store(Path(store) if store else default_path()) as stored:
        added = sum(stored.merge(other) for other in others)
        click.echo(f"{added} runs added; {stored.path} holds {len(stored)}")
