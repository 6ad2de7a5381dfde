"""mbs-ref merge: join stores of runs."""

from pathlib import Path

import click

from cross_checks.records.store import Store
from reports import inputs
from reports.query import STORE, store_path


@click.command(name="merge", epilog="Example: mbs-ref merge part-1.sqlite part-2.sqlite")
@click.argument("others", nargs=-1, required=True, type=inputs.FILE, metavar="FILE.sqlite...")
@STORE
def command(others: tuple[Path, ...], store: str | None) -> None:
    """Add the runs of other stores to the store. They are of shards or other machines."""
    with Store(store_path(store)) as stored:
        added = sum(stored.merge(other) for other in others)
        click.echo(f"{added} runs added; {stored.path} holds {len(stored)}")
