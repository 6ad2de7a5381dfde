"""What proofs cover of a scene's parts."""

import math
from collections.abc import Iterator
from typing import Any

from mbs_ref.scene import GROUND

ENERGETIC = ("spring_damper", "torsion_spring", "newton", "oblateness", "epoch")  # loads whose energy is counted
CONSTANT = ("force", "torque", "torque_vector", "epoch")  # loads that depend on no distance
DRIVES = ("coordinate_drive", "point_drive")
JOINTS = ("revolute", "prismatic", "weld", "spherical", "distance", "universal", *DRIVES)
SIGNALS = ("constant", "harmonic", "polynomial")  # without breakpoints
PLANES, PAIRS = ("circle_on_line", "sphere_on_plane"), ("circle_on_circle", "sphere_on_sphere")
TURNS = {"point_mass": 0, "planar": 1, "spatial": 4}  # numbers of a turn: none, angle, Euler parameters
ROD_GAP = 1e-12  # of a rod's length: how far its points may be from it at t = 0; the start decides


def complaints(scene: Any) -> Iterator[str]:
    """Yield why no proof covers a scene."""
    if scene.events or (scene.contacts and (scene.joints or {load.type for load in scene.loads} - {*CONSTANT})):
        yield "events, and contacts beside joints, springs or attraction, are not covered"
    places = {body.name: tuple(body.position) for body in scene.bodies}
    for kind, parts, reason in (
        ("joint", scene.joints, _of_joint), ("load", scene.loads, _of_load),
        ("contact", scene.contacts, lambda part: _of_contact(part, places)),
    ):  # fmt: skip
        yield from (f"{kind} {part.name} ({part.type}) {why}" for part in parts if (why := reason(part)))


def _of_joint(joint: Any) -> str:
    if joint.type in DRIVES:
        return "" if joint.motion.type in SIGNALS else "follows a signal with breakpoints, which is not covered"
    rod, axis = joint.type == "distance", getattr(joint, "axis", None)
    if rod and joint.length and abs(joint.length / math.dist(joint.point_a, joint.point_b) - 1.0) > ROD_GAP:
        return "is not closed at t = 0, which is not covered"
    if joint.type == "revolute" and axis is not None and sum(x != 0.0 for x in axis) != 1:
        return "has an axis that is no coordinate axis, which is not covered"
    return "" if joint.type in JOINTS and (rod or not getattr(joint, "point_b", None)) else "is not covered"


def _of_load(load: Any) -> str:
    if load.type not in (*ENERGETIC, *CONSTANT) or getattr(load, "tension_only", False):
        return "is not covered"
    if getattr(getattr(load, "factor", None), "type", "constant") not in SIGNALS:
        return "follows a signal with breakpoints, which is not covered"
    if getattr(load, "frame", "world") == "body" or (load.type == "torsion_spring" and load.axis):
        return "along a body's axes, or about an axis in space, is not covered"
    fixed = load.type != "oblateness" or (load.pole == "fixed" and sorted(map(abs, load.axis)) == [0.0, 0.0, 1.0])
    return "" if fixed else "needs a fixed pole along a coordinate axis"


def _of_contact(part: Any, places: dict[str, Any]) -> str:
    plane = part.type in PLANES
    if part.type not in (*PLANES, *PAIRS) or part.law.type != "rigid_law" or not part.law.restitution:
        return "is not covered: impacts with rebound of circles and spheres alone are"
    if plane and (part.body_b != GROUND or part.extent not in ("line", "plane") or part.thickness):
        return "has a surface that moves or ends, which is not covered"
    centres = {part.body_a: part.center} if plane else {part.body_a: part.center_a, part.body_b: part.center_b}
    inside = all(places.get(name) == tuple(centre) for name, centre in centres.items())
    return "" if inside else "has a centre that is not the centre of mass, which is not covered"
