"""A script that runs in Exudyn alone."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import reduce
from itertools import islice
from math import gcd
from typing import Any

import numpy as np

from cross_checks.engine.prescribed import Prescribed
from cross_checks.engines import get
from cross_checks.engines.writers.carried import array_text, forces_text, motion_text
from cross_checks.engines.writers.exudyn_items import changed, functions, general_contact, lines, name_of
from cross_checks.engines.writers.form import Form, Job, job_of, refuse_own
from cross_checks.engines.writers.literals import literal
from cross_checks.engines.writers.script import script, source
from cross_checks.linkage.forces import Applied
from cross_checks.linkage.motion import arrays_of
from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.euler_parameters import from_matrix
from mbs_ref.scene.signals import Segment
from mbs_ref.settings import Settings


def write_exudyn(scene: Scene, settings: Settings) -> str:
    """Return the script: Exudyn's system item by item, its solver's settings, and what its sensors recorded."""
    get("exudyn")  # raises EngineMissing before the adapter's own modules are imported
    from cross_checks.engines.exudyn_.contact import add_contacts
    from cross_checks.engines.exudyn_.methods import CONTACT, SOLVERS

    refuse_own(scene, "exudyn")
    job = job_of(scene, settings, "exudyn")
    model, plan = job.built.model, job.plan
    contact = general_contact(model, add_contacts) if plan.method.name == CONTACT else []
    default = type(job.built.options)()
    tree = getattr(model, "linkage", None)
    called = [Called(function) for function in functions(model.mbs)]
    return script(
        job, "exudyn and numpy", items=list(lines(model.mbs)), contact=contact,
        functions=[one.text(name_of(one.function, functions(model.mbs))) for one in called],
        forces=next((forces_text(one.applied) for one in called if one.applied is not None), ""),
        options=list(changed(job.built.options, default)), solver=SOLVERS[plan.method.name].name,
        every=reduce(gcd, plan.counts) if plan.counts else 0, sensors=[] if tree else list(_sensors(job)),
        motion="" if tree is None or tree.loaded else motion_text(arrays_of(tree)), tree=tree is not None,
        turn=source(from_matrix),
        prescribed=source(Segment, Prescribed),
        sparse=job.built.loops and job.built.options.linearSolver.solverType.name != "EigenDense",
    )  # fmt: skip


@dataclass(frozen=True)
class Called:
    """A function of the adapter's that Exudyn calls, with what it holds."""

    function: Callable[..., Any]

    @property
    def held(self) -> dict[str, Any]:
        return dict(inspect.getclosurevars(self.function).nonlocals)

    @property
    def applied(self) -> Applied | None:
        return next((value for value in self.held.values() if isinstance(value, Applied)), None)

    def text(self, name: str) -> str:
        """Return a function that sets up what this one holds, and returns it; then its call."""
        values = "".join(f"    {key} = {_held(value)}\n" for key, value in self.held.items())
        own = textwrap.indent(source(self.function), "    ")
        return f"def _make_{name}():\n{values}{own}    return {self.function.__name__}\n\n\n{name} = _make_{name}()\n"


def _held(value: Any) -> str:
    """Return Python text of what a function of the adapter's holds."""
    if isinstance(value, Applied):
        return "FORCES"
    if isinstance(value, Prescribed):
        return f"Prescribed([{', '.join(f'Segment(*{literal(tuple(one))})' for one in value.segments)}])"
    return array_text(value) if isinstance(value, np.ndarray) else literal(value)


def _sensors(job: Job) -> Iterator[tuple[Any, ...]]:
    """Yield where each body starts, and its sensors: Exudyn counts a planar body's coordinates from its start."""
    numbers = (sensor.GetIndex() for sensor in job.built.model.sensors)
    for body in job.scene.bodies:
        turns = isinstance(body, PlanarBody | SpatialBody)
        planar = job.scene.dimension == 2
        start = [*body.position, getattr(body, "angle", 0.0)] if planar else []
        yield start, turns, list(islice(numbers, 4 if turns and not planar else 2))


FORM = Form("exudyn", ".py", "a script that runs in Exudyn alone", write_exudyn)
