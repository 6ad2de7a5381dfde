"""A script that runs in Exudyn alone: the assembled system item by item, as Exudyn reports it."""

from collections.abc import Iterator
from functools import reduce
from itertools import islice
from math import gcd
from typing import Any

import numpy as np

from cross_checks.linkage.forces import BY_SHARED_CODE
from cross_checks.writers import Form, Job, job_of, literal, refuse, refuse_shared, script, turns_of
from mbs_ref import Settings
from mbs_ref.scene import PlanarBody, Scene, SpatialBody

KINDS = ("Node", "Object", "Marker", "Load", "Sensor")  # in this order, items refer only to earlier ones
NAMED = "UserFunction"  # in the names of fields that hold Python functions, as {"function": ..., "type": ...}


def items(mbs: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the kind and the fields of every item, without its looks and its automatic name."""
    for kind in KINDS:
        count = getattr(mbs.systemData, f"NumberOf{kind}s")()
        for number in range(count):
            fields = getattr(mbs, f"Get{kind}")(number)
            if "trianglePoints" in fields:  # Exudyn 1.13 calls a sphere on a triangle a sphere on a sphere
                fields["objectType"] = "ContactSphereTriangle"
            yield kind, {key: value for key, value in fields.items() if key != "name" and not key.startswith("V")}


def text(value: Any) -> str:
    """Return Python text of a field."""
    kind = type(value).__name__
    if kind in ("Matrix3DList", "Vector3DList"):
        return f"exu.{kind}({literal([np.array(one) for one in value.GetPythonObject()])})"
    if kind == "MatrixContainer":
        return f"np.array({literal(value.Convert2DenseMatrix())})"
    if hasattr(value, "GetIndex"):  # of a node, an object, a marker
        return str(value.GetIndex())
    if hasattr(type(value), "__members__"):
        return f"exu.{kind}.{value.name}"
    if isinstance(value, list):
        return f"[{', '.join(map(text, value))}]"
    return literal(value)


def changed(given: dict[str, Any], usual: dict[str, Any], path: str = "options") -> Iterator[str]:
    """Yield the assignments that turn Exudyn's default settings into others."""
    for name, value in given.items():
        if isinstance(value, dict):
            yield from changed(value, usual[name], f"{path}.{name}")
        elif not np.array_equal(value, usual[name]):
            yield f"{path}.{name} = {text(value)}"


def general_contact(model: Any) -> Iterator[str]:
    """Yield the calls and assignments that make the model's general contact, if it has one."""
    if general := getattr(model, "general", ()):
        yield "general = mbs.AddGeneralContact()"
    for name, values, named in general:
        given = ", ".join([*map(_array, values), *(f"{key}={_array(value)}" for key, value in named.items())])
        yield f"general.{name}({given})" if name[0].isupper() else f"general.{name} = {given}"


def _array(value: Any) -> str:
    return f"np.array({literal(value)})" if isinstance(value, np.ndarray) else text(value)


def write_exudyn(scene: Scene, settings: Settings) -> str:
    """Return the script: Exudyn's system item by item, its solver's settings, and what its sensors record.

    Raises NotWritable naming each part for which Exudyn calls a Python function of the adapter.
    """
    job = job_of(scene, settings, "exudyn")  # raises EngineMissing before the adapter's modules are imported
    from cross_checks.engines.exudyn_.run import SOLVERS

    model, plan, options = job.built.model, job.plan, job.built.options
    if any(BY_SHARED_CODE in note for note in model.notes):
        refuse_shared(job)
    parts = list(items(model.mbs))
    if any(NAMED in key and isinstance(value, dict) for _, fields in parts for key, value in fields.items()):
        refuse(scene, "exudyn", model.notes)
    lines = [f"mbs.Add{kind}({{{', '.join(f'{key!r}: {text(value)}' for key, value in fields.items())}}})"
             for kind, fields in parts]  # fmt: skip
    tree = getattr(model, "linkage", None)
    sensors = list(_link_sensors(model) if tree else _sensors(job))
    return script(
        job, "exudyn and numpy", items=lines, sensors=sensors, tree=tree is not None,
        number=getattr(model, "number", -1),
        contact=list(general_contact(model)),
        options=list(changed(options.GetDictionary(), type(options)().GetDictionary())),
        solver=SOLVERS[plan.method.name].name,
        every=reduce(gcd, plan.counts) if plan.counts else 0, turns=turns_of(scene) if tree else None,
        sparse=job.built.loops and options.linearSolver.solverType.name != "EigenDense",
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
        planar = job.built.model.scene.planar
        start = [*body.position, getattr(body, "angle", 0.0)] if planar else []
        yield start, turns, list(islice(numbers, 4 if turns and not planar else 2))


FORMS = (Form("exudyn", ".py", "a script that runs in Exudyn alone", write_exudyn),)
