"""What all scripts share: the head, the outputs, and columns as `mbs-ref simulate -o` writes and `judge` reads them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template

from cross_checks.linkage.links import linkage_of
from cross_checks.writers.form import Job
from cross_checks.writers.literals import counts_text, literal, rows, times_text
from mbs_ref.scene import Scene

PLANAR = ["x", "y", "angle", "vx", "vy", "rate"]
SPATIAL = ["x", "y", "z", "e0", "e1", "e2", "e3", "vx", "vy", "vz", "wx", "wy", "wz"]


@cache
def _templates() -> Environment:
    return Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        undefined=StrictUndefined, keep_trailing_newline=True, trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip


def template(name: str) -> Template:
    """Return the text that an engine's script is made from, or a part of it."""
    return _templates().get_template(name)


def script(job: Job, needs: str, **tables: Any) -> str:
    """Return the script of the engine's template; `needs` names the packages it runs with."""
    scene, plan = job.scene, job.plan
    planar = scene.dimension == 2
    return (
        template(f"{job.engine.name}.py.j2")
        .render(
            job=job, plan=plan, needs=needs, planar=planar, columns=PLANAR if planar else SPATIAL,
            bodies=scene.body_names, times=times_text(plan.times),
            counts=counts_text(plan.counts) if plan.counts else "",
            literal=literal, rows=rows, **tables,
        )
    )  # fmt: skip


def turns_of(scene: Scene) -> list[tuple[float, list[int]]]:
    """Return each planar body's angle at t = 0 (rad), and the coordinates of the linkage that turn it."""
    linkage = linkage_of(scene)
    each = zip(linkage.angle, linkage.turns, strict=True)
    return [(float(angle), np.flatnonzero(row).tolist()) for angle, row in each]
