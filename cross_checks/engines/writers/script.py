"""What all scripts share: the head, the outputs, and columns as `mbs-ref simulate -o` writes and `judge` reads them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template

from cross_checks.engines.writers.form import Job
from cross_checks.engines.writers.literals import counts_text, literal, rows, times_text
from cross_checks.workshop.planar_tree import joint_tree
from mbs_ref.scene import PlanarBody, Scene

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
    """Return each planar body's angle at t = 0 (rad), and the coordinates of the joint tree that turn it."""
    tree = joint_tree(scene)
    unit = np.eye(tree.size)
    _, _, _, rate = tree.poses(np.zeros_like(unit), unit)  # (n_q, n_bodies): what each coordinate's rate turns
    assert set(np.unique(rate)) <= {0.0, 1.0}  # coordinates turn one way, and by their own angle
    start = [body.angle if isinstance(body, PlanarBody) else 0.0 for body in scene.bodies]
    return [(angle, np.flatnonzero(rate[:, k]).tolist()) for k, angle in enumerate(start)]
