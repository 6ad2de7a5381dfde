"""A script that runs in Exudyn alone."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from itertools import islice
from math import gcd
from typing import Any

from cross_checks.engines import get
from cross_checks.engines.writers.exudyn_items import changed, functions, general_contact, lines, stands_alone
from cross_checks.engines.writers.form import Form, Job, NotWritable, job_of, refuse, refuse_shared
from cross_checks.engines.writers.script import script, source
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.settings import Settings

CALLS = "calls Python"  # what the adapter's notes say of a part


def write_exudyn(scene: Scene, settings: Settings) -> str:
    """Return the script: Exudyn's system item by item, its solver's settings, and what its sensors recorded."""
    adapter = get("exudyn")  # its absence is said here, before what the adapter is made of is asked for
    from cross_checks.engines.exudyn_.contact import add_contacts
    from cross_checks.engines.exudyn_.methods import CONTACT, SOLVERS, TREE

    name = adapter.method(settings.method).name
    if name.startswith(TREE):
        written = [method.name for method in adapter.methods() if not method.name.startswith(TREE)]
        raise NotWritable(f"method = {name!r} is not yet written as a script; allowed: {', '.join(written)}")
    job = job_of(scene, settings, "exudyn")
    model, plan = job.built.model, job.plan
    _refuse(job)
    contact = general_contact(model, add_contacts) if name == CONTACT else []
    default = type(job.built.options)()
    return script(
        job, "exudyn and numpy", items=list(lines(model.mbs)), contact=contact,
        functions=source(*functions(model.mbs).values()), options=list(changed(job.built.options, default)),
        solver=SOLVERS[name].name, every=reduce(gcd, plan.counts), sensors=list(_sensors(job)),
        turn=source(from_matrix),
        sparse=job.built.loops and job.built.options.linearSolver.solverType.name != "EigenDense",
    )  # fmt: skip


def _refuse(job: Job) -> None:
    """Refuse what Exudyn asks our Python for."""
    known = functions(job.built.model.mbs)
    strange = [name for name, function in known.items() if not stands_alone(function)]
    if not strange:
        return
    told = [note for note in job.built.model.notes if CALLS in note]
    if told:
        refuse(job.scene, "exudyn", (f"{note}, and that function is ours" for note in told))
    refuse_shared(job)


def _sensors(job: Job) -> Iterator[tuple[Any, ...]]:
    """Yield where each body starts, and its sensors: Exudyn counts a planar body's coordinates from its start."""
    numbers = (sensor.GetIndex() for sensor in job.built.model.sensors)
    for body in job.scene.bodies:
        turns = isinstance(body, PlanarBody | SpatialBody)
        planar = job.scene.dimension == 2
        start = [*body.position, getattr(body, "angle", 0.0)] if planar else []
        yield start, turns, list(islice(numbers, 4 if turns and not planar else 2))


FORM = Form("exudyn", ".py", "a script that runs in Exudyn alone", write_exudyn)
