"""A scene that starts where a motion of another has ended, or goes back from there."""

from itertools import chain

from mbs_ref import Scene, Trajectory
from mbs_ref.simulate.start.equilibrium import restated

KNOWN = frozenset({
    "planar", "point_mass", "spatial", "revolute", "spherical", "universal", "prismatic", "weld", "distance",
    "spring_damper", "force", "circle_on_line", "circle_on_circle", "sphere_on_plane", "sphere_on_sphere", "newton",
    "relativity", "oblateness", "epoch",
})  # fmt: skip
FORGETFUL = frozenset({"spring_damper_law", "progressive_law", "hunt_crossley_law", "rigid_law"})


def obstacle(scene: Scene, *, back: bool) -> str:
    """Return why a run of the scene cannot be cut (or turned back), or nothing."""
    strange = sorted({p.type for p in chain(scene.bodies, scene.joints, scene.loads, scene.contacts)} - KNOWN)
    if strange:
        return f"{', '.join(strange)} are not carried over a cut"
    if any(getattr(load, "pole", "fixed") != "fixed" or getattr(load, "tension_only", False) for load in scene.loads):
        return "dates, and ropes that may be slack, are not carried over a cut"
    if any(load.type == "force" and load.factor.type != "constant" for load in scene.loads):
        return "signals are not carried over a cut"
    if any(c.law.type not in FORGETFUL or getattr(c.friction, "type", "") == "stick_slip" for c in scene.contacts):
        return "a contact that remembers its impact or its grip is not carried over a cut"
    return _loss(scene) if back else ""


def _loss(scene: Scene) -> str:
    lossy = [load.name for load in scene.loads if getattr(load, "damping", 0.0) or load.type == "force"]
    for contact in scene.contacts:
        elastic = getattr(contact.law, "restitution", 1.0) == 1.0 and not getattr(contact.law, "damping", 0.0)
        if contact.friction is not None or not elastic:
            lossy.append(contact.name)
    return f"{', '.join(lossy)} may take energy" if lossy else ""


def continued(scene: Scene, run: Trajectory, *, back: bool) -> Scene:
    """Return the scene that starts at the run's end; with all velocities reversed if it goes `back`."""
    cut = restated(scene, run, -1.0 if back else 1.0)
    return cut.model_copy(update={"name": "cut", "parameters": {}, "events": ()})
