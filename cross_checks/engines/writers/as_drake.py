"""A script that runs in Drake alone: the adapter's own code over the links of the scene."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cross_checks.engines import get
from cross_checks.engines.writers.carried import forces_text
from cross_checks.engines.writers.form import Form, NotWritable, job_of, refuse_own
from cross_checks.engines.writers.script import script, source
from cross_checks.linkage.links import Closure, Link
from mbs_ref.scene import Scene
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.settings import Settings


def write_drake(scene: Scene, settings: Settings) -> str:
    """Return the script: the links and closures of the scene, and what the adapter builds and reads with."""
    adapter = get("drake")  # raises EngineMissing before the adapter's own modules are imported
    from cross_checks.engines.drake_ import build, reader, run
    from cross_checks.engines.drake_.methods import SAP, WORLD

    if adapter.method(settings.method).name == WORLD:
        raise NotWritable(f"method = {WORLD!r} ends the process that runs it; allowed: {SAP}")
    job = job_of(scene, settings, "drake")
    refuse_own(scene, "drake")
    applied = job.built.applied
    linkage = job.built.linkage
    building = (build.plant_of, build.tied_to_ground, build._anchor, build._inertia, build._joint, build._add_closure)
    return script(
        job, "drake and numpy", links=list(_fields(linkage.links, Link)),
        gravity=linkage.gravity if applied is None else np.zeros(3),  # with loads, it comes with them
        forces="" if applied is None else forces_text(applied), pushing=source(run.Loads),
        closures=list(_fields(linkage.closures, Closure)), table=source(Link, Closure), building=source(*building),
        reader=source(reader.Reader), turning=source(from_matrix),
        landing=source(run.is_discrete, run._landings), choosing=source(run._choose_integrator),
        simulating=source(run.Simulated, run.simulated),
    )  # fmt: skip


def _fields(parts, kind) -> Iterator[tuple]:
    """Yield the fields of each part in their order."""
    for part in parts:
        yield tuple(getattr(part, name) for name in kind.__dataclass_fields__)


FORM = Form("drake", ".py", "a script that runs in Drake alone", write_drake)
