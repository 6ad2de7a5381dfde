"""mbs-ref compile: the solver's kernels, once for each change of their sources."""

import click

from cross_checks.records.store import Store
from mbs_ref.kernels.jit import cache_folder
from reports.console import awaited, progress
from reports.query import STORE, store_path


@click.command(name="compile", epilog="Example: mbs-ref compile")
@STORE
def command(store: str | None) -> None:
    """Compile the solver's kernels on all cores. No later run waits for them; nothing is done twice."""
    from reports.facts.compiling import compile_kernels

    what = "compiling the solver for plane, space and particles side by side: a minute or two, once a change"
    with Store(store_path(store)) as stored, awaited(what), progress("compile") as report:
        compile_kernels(stored, report, lanes=True)
    click.echo(f"the solver is compiled, in {cache_folder()}")
