"""The store that commands ask, and the process that makes the runs which it lacks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import click

from cross_checks.isolation.parent import MEMORY, TIMEOUT, Isolated, direct
from cross_checks.judge.runs import Runs
from cross_checks.records.store import Store, default_path
from mbs_ref.scene import Scene
from mbs_ref.scene.traits import python_parts

STORE = click.option(
    "--store", metavar="FILE.sqlite", help="The store of runs.  [default: MBS_REF_STORE, or one in the cache folder]"
)


def store_path(named: str | None) -> Path:
    """Return the file of the store: the one named, else the machine's."""
    return Path(named) if named else default_path()


@contextmanager
def asked_runs(
    scenes: Iterable[Scene], store: str | None = None, timeout: float | None = None, memory_mib: float | None = None
) -> Iterator[Runs]:
    """Open the store and a process for its runs, each within `timeout` (s) and `memory_mib`.

    A user's Python function cannot travel to another process: scenes that have one run in this process.
    """
    with Store(store_path(store)) as kept, isolated(scenes, timeout, memory_mib) as call:
        yield Runs(kept, call)


def isolated(scenes: Iterable[Scene], timeout: float | None = None, memory_mib: float | None = None):
    """Return what makes calls in a process of their own, where the scenes can travel there."""
    if any(python_parts(scene) for scene in scenes):
        return nullcontext(direct)
    return Isolated(timeout or TIMEOUT, MEMORY if memory_mib is None else int(memory_mib * 2**20))
