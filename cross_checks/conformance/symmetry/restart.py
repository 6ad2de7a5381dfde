"""A scene that starts where a motion of another has ended, or goes back from there."""

import math
from itertools import chain
from typing import Any

import numpy as np

from cross_checks.conformance.figures import axes
from mbs_ref.scene import Scene
from mbs_ref.trajectory import Trajectory

OF_B = frozenset({"point_b", "center_b", "point_1", "point_2", "axle", "axis_b"})
POINTS = frozenset({"point", "point_a", "center", "center_a"}) | (OF_B - {"axis_b"})
DIRECTIONS = frozenset({"axis", "axis_a", "axis_b", "normal", "edge"})
ON_B = frozenset({"sphere_on_plane"})  # whose one surface is on body b
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
    sign = -1.0 if back else 1.0
    bodies = []
    for k, body in enumerate(scene.bodies):
        new: dict[str, Any] = {
            "position": tuple(run.position[-1, k].tolist()), "velocity": tuple((sign * run.velocity[-1, k]).tolist()),
        }  # fmt: skip
        if body.type == "planar":
            new["angle"] = float(run.orientation[-1, k])
            new["angular_velocity"] = sign * float(run.angular_velocity[-1, k])
        elif body.type == "spatial":
            theta = run.orientation[-1, k] / np.linalg.norm(run.orientation[-1, k])
            new["orientation"] = tuple(theta.tolist())
            new["angular_velocity"] = tuple((sign * run.angular_velocity[-1, k]).tolist())
        bodies.append(body.model_copy(update=new))
    kinds = ("joints", "loads", "contacts")
    groups = {kind: tuple(_carried(scene, run, part) for part in getattr(scene, kind)) for kind in kinds}
    return scene.model_copy(update={"name": "cut", "parameters": {}, "bodies": tuple(bodies), "events": (), **groups})


def _carried(scene: Scene, run: Trajectory, part: Any) -> Any:
    """Return a part whose marks are where their bodies have taken them."""
    changed: dict[str, Any] = {}
    if part.type in ("spring_damper", "distance"):
        name = "rest_length" if part.type == "spring_damper" else "length"
        if getattr(part, name) is None:
            changed[name] = math.dist(part.point_a, part.point_b)
    if part.type in ("newton", "relativity", "oblateness", "epoch"):
        return part
    for name in type(part).model_fields:
        value = getattr(part, name)
        if value is None or name not in POINTS | DIRECTIONS:
            continue
        of_b = name in OF_B or (part.type in ON_B and name != "center")
        body = getattr(part, "body", None) or (part.body_b if of_b else part.body_a)
        changed[name] = _moved(scene, run, body, np.array(value), name in POINTS)
    return part.model_copy(update=changed)


def _moved(scene: Scene, run: Trajectory, body: str, value: np.ndarray, is_point: bool) -> tuple[float, ...]:
    if body == "ground":
        return tuple(value.tolist())
    k = scene.body_index(body)
    before, after = axes(scene, run.orientation[[0, -1], k])
    if not is_point:
        return tuple((after @ before.T @ value).tolist())
    return tuple((run.position[-1, k] + after @ before.T @ (value - run.position[0, k])).tolist())
