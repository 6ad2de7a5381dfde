"""A script that runs in Drake alone, from the links of the scene."""

import numpy as np

from cross_checks.engines import get
from cross_checks.linkage.links import SIX, Link, Linkage
from cross_checks.writers import Form, NotWritable, job_of, script, turns_of
from mbs_ref import Settings
from mbs_ref.scene import Scene, SpatialBody


def write_drake(scene: Scene, settings: Settings) -> str:
    """Return the script: links and closures as tables, from which it builds Drake's plant.

    Raises NotWritable where the adapter's force code acts, or for the method that ends its process.
    """
    adapter = get("drake")  # raises EngineMissing before the adapter's modules are imported
    from cross_checks.engines.drake_ import FIXED, SAP, WORLD
    from cross_checks.engines.drake_.build import constraints_of, tied_to_ground

    if adapter.method(settings.method).name == WORLD:
        raise NotWritable(f"method = {WORLD!r} ends the process that runs it; allowed: {SAP}")
    job = job_of(scene, settings, "drake")
    linkage, method = job.built.linkage, job.plan.method.name
    return script(
        job, "drake and numpy", links=[_link(linkage, link) for link in linkage.links], gravity=linkage.gravity,
        closures=[row for closure in linkage.closures for row in constraints_of(linkage, closure)],
        anchored=tied_to_ground(linkage), discrete=method == SAP, integrator=method.removesuffix(FIXED),
        turns=turns_of(scene),
        start=[body.orientation if isinstance(body, SpatialBody) else None for body in scene.bodies],
    )  # fmt: skip


def _link(linkage: Linkage, link: Link) -> tuple:
    """Return a row of the table of links."""
    from cross_checks.engines.drake_.build import ALONG_AXIS, JOINTS

    turn = np.column_stack((*link.axes, np.cross(*link.axes))).tolist() if link.kind == "universal" else []
    axes = link.axes.tolist() if link.kind in ALONG_AXIS else []
    place = link.origin - linkage.origin(link.parent)
    return (
        link.name, link.body, link.parent, place, JOINTS[link.kind], axes, turn,
        float(link.mass), link.centre, link.inertia[SIX], link.turning_first,
    )  # fmt: skip


FORMS = (Form("drake", ".py", "a script that runs in Drake alone", write_drake),)
