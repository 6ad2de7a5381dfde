"""A script that runs in Exudyn alone."""

from collections.abc import Iterator
from functools import reduce
from itertools import islice
from math import gcd
from typing import Any

import numpy as np

from cross_checks.engines import get
from cross_checks.linkage.forces import BY_SHARED_CODE
from cross_checks.writers.exudyn_items import calls_python, changed, general_contact, lines
from cross_checks.writers.script import Form, Job, job_of, refuse, refuse_shared, script, turns_of
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.settings import Settings


def write_exudyn(scene: Scene, settings: Settings) -> str:
    """Return the script: Exudyn's system item by item, its solver's settings, and what its sensors record.

    Raises NotWritable naming each part for which Exudyn calls a Python function of the adapter.
    """
    get("exudyn")  # raises EngineMissing before the adapter's modules are imported
    from cross_checks.engines.exudyn_.contact import add_contacts
    from cross_checks.engines.exudyn_.run import CONTACT, SOLVERS

    job = job_of(scene, settings, "exudyn")
    model, plan = job.built.model, job.plan
    if any(BY_SHARED_CODE in note for note in model.notes):
        refuse_shared(job)
    if calls_python(model.mbs):
        refuse(scene, "exudyn", model.notes)
    tree = getattr(model, "linkage", None)
    sensors = list(_link_sensors(model) if tree else _sensors(job))
    return script(
        job, "exudyn and numpy", items=list(lines(model.mbs)), sensors=sensors, tree=tree is not None,
        number=getattr(model, "number", -1),
        contact=general_contact(model, add_contacts) if plan.method.name == CONTACT else [],
        options=list(changed(job.built.options, type(job.built.options)())), solver=SOLVERS[plan.method.name].name,
        every=reduce(gcd, plan.counts) if plan.counts else 0, turns=turns_of(scene) if tree else None,
        sparse=job.built.loops and job.built.options.linearSolver.solverType.name != "EigenDense",
    )  # fmt: skip


def _link_sensors(model: Any) -> Iterator[tuple[int, list[float]]]:
    """Yield the link of a KinematicTree that carries each body, and the body's centre of mass in it (m)."""
    links = model.linkage.links
    welded = (f"body {one.name!r} is welded to ground" for one in links if not one.freedoms)
    refuse(model.linkage.scene, "exudyn", welded)
    last = np.cumsum([len(one.freedoms) for one in links]) - 1  # a joint's first links are massless
    number = {one.body: int(k) for one, k in zip(links, last, strict=True)}
    for body in range(len(links)):
        yield number[body], model.centres[number[body]].tolist()


def _sensors(job: Job) -> Iterator[tuple[Any, ...]]:
    """Yield where each body starts, and its sensors: Exudyn counts a planar body's coordinates from its start."""
    numbers = (sensor.GetIndex() for sensor in job.built.model.sensors)
    for body in job.scene.bodies:
        turns = isinstance(body, PlanarBody | SpatialBody)
        planar = job.built.model.planar
        start = [*body.position, getattr(body, "angle", 0.0)] if planar else []
        yield start, turns, list(islice(numbers, 4 if turns and not planar else 2))


FORMS = (Form("exudyn", ".py", "a script that runs in Exudyn alone", write_exudyn),)
