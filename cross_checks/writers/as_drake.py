"""A script that runs in Drake alone, from the links of the scene."""

from collections.abc import Iterator

import numpy as np

from cross_checks.engines import get
from cross_checks.linkage.links import FIXED, Closure, Link, Linkage
from cross_checks.writers.script import Form, NotWritable, job_of, refuse_shared, script, turns_of
from mbs_ref import Settings
from mbs_ref.scene import Scene, SpatialBody

# Drake's joint of each kind of link
JOINTS = {
    "revolute": "RevoluteJoint", "prismatic": "PrismaticJoint", "universal": "UniversalJoint", "ball": "BallRpyJoint",
    "planar": "PlanarJoint", "free": "QuaternionFloatingJoint", "weld": "WeldJoint",
}  # fmt: skip
ALONG_AXIS = ("revolute", "prismatic")
ANGULAR_FIRST = [3, 4, 5, 0, 1, 2]  # Drake's order of a free body's rates: angular velocity, velocity
INERTIA = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])  # xx, yy, zz, xy, xz, yz


def write_drake(scene: Scene, settings: Settings) -> str:
    """Return the script: links and closures as tables, from which it builds Drake's plant.

    Raises NotWritable where the adapter's force code acts, or for the method that ends its process.
    """
    adapter = get("drake")  # raises EngineMissing before the adapter's modules are imported
    from cross_checks.engines.drake_.run import FIXED as FIXED_STEP
    from cross_checks.engines.drake_.run import SAP, WORLD

    if adapter.method(settings.method).name == WORLD:
        raise NotWritable(f"method = {WORLD!r} ends the process that runs it; allowed: {SAP}")
    job = job_of(scene, settings, "drake")
    if job.built.applied is not None:
        refuse_shared(job)
    linkage, method = job.built.linkage, job.plan.method.name
    return script(
        job, "drake and numpy", links=[_link(linkage, link) for link in linkage.links], gravity=linkage.gravity,
        closures=[row for closure in linkage.closures for row in _closure(linkage, closure)],
        anchored=any(FIXED in (closure.a, closure.b) for closure in linkage.closures),
        discrete=method == SAP, integrator=method.removesuffix(FIXED_STEP),
        turns=turns_of(scene),
        start=[body.orientation if isinstance(body, SpatialBody) else None for body in scene.bodies],
    )  # fmt: skip


def _link(linkage: Linkage, link: Link) -> tuple:
    """Return a row of the table of links."""
    turn = np.column_stack((*link.axes, np.cross(*link.axes))).tolist() if link.kind == "universal" else []
    axes = link.axes.tolist() if link.kind in ALONG_AXIS else []
    rates = link.rates[ANGULAR_FIRST] if link.kind == "free" else link.rates
    place = link.origin - linkage.origin(link.parent)
    return (
        link.name, link.body, link.parent, place, JOINTS[link.kind], axes, turn,
        float(link.mass), link.centre, link.inertia[INERTIA], rates,
    )  # fmt: skip


def _closure(linkage: Linkage, closure: Closure) -> Iterator[tuple]:
    """Yield rows of the table of closures; a hinge is two shared points on its axis."""
    kind = {"rod": "AddDistanceConstraint", "weld": "AddWeldConstraint"}.get(closure.kind, "AddBallConstraint")
    at_a, at_b = closure.point_a - linkage.origin(closure.a), closure.point_b - linkage.origin(closure.b)
    length = (closure.length,) if closure.kind == "rod" else ()
    for along in (-0.5, 0.5) if closure.kind == "hinge" else (0.0,):
        yield (kind, closure.a, at_a + along * closure.axis, closure.b, at_b + along * closure.axis, *length)


FORMS = (Form("drake", ".py", "a script that runs in Drake alone", write_drake),)
