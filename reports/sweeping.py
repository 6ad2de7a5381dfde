"""Run a sweep with a bar, keep what was computed when it is interrupted, and write the lines."""

from __future__ import annotations

from pathlib import Path

import click

from cross_checks import engines
from cross_checks.record import Record
from mbs_ref.atomic import write_atomic
from mbs_ref.scene import Scene
from reports import inputs
from reports.console import json_text, progress
from reports.exit_codes import Incomplete


def sweep_records(scene: Scene, chosen: tuple[str, ...], methods: tuple[str, ...], target: Path | None) -> list[Record]:
    """Return the sweep's records and write them to `target`; Incomplete where it is interrupted."""
    from benchmarks import sweep

    for name in chosen:
        inputs.engine(name)
    records: list[Record] = []
    try:
        with progress(f"sweep {scene.name}") as report:
            records.extend(sweep.sweep(scene, list(chosen) or engines.names(), list(methods) or None, report))
    except ValueError as error:  # a method that none of the engines offers
        raise click.UsageError(str(error)) from error
    except KeyboardInterrupt:
        raise Incomplete(f"interrupted after {len(records)} records") from None
    finally:
        if target is not None and records:
            write_atomic(target, "".join(f"{json_text(r.to_dict(), None)}\n" for r in records).encode())
    return records
