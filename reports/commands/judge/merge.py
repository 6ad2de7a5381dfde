"""mbs-ref merge: join stores of runs."""

from __future__ import annotations

from pathlib import Path

import click

from cross_checks.records.store import Store, default_path
from reports.asking import STORE

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


@click.command(name="merge")
@click.argument("others", nargs=-1, required=True, type=FILE, metavar="FILE.sqlite...")
@STORE
def command(others: tuple[Path, ...], store: str | None) -> None:
    """Add the runs of other stores, of shards or of other machines, to the store."""
    with Store(Path(store) if store else default_path()) as kept:
        added = sum(kept.merge(other) for other in others)
        click.echo(f"{added} runs added; {kept.path} holds {len(kept)}")
