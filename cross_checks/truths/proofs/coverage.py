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
ROD_GAP = 1e-12  # of a rod's length: how far its points may be from it at t = 0; the start decides


def complaints(scene: Any) -> Iterator[str]:
    """Yield why no proof covers a scene."""
    if scene.events or (scene.contacts and (scene.joints or {load.type for load in scene.loads} - {*CONSTANT})):
        yield "events, and contacts beside joints, springs or attraction, are not covered"
    places = {body.name: tuple(body.position) for body in scene.bodies}
    for kind, parts in (("joint", scene.joints), ("load", scene.loads), ("contact", scene.contacts)):
        for part in parts:
            if reason := next((words for words, holds in _reasons(part, places) if holds), None):
                yield f"{kind} {part.name} ({part.type}) {reason}"


def _reasons(part: Any, places: dict[str, Any]) -> Iterator[tuple[str, bool]]:
    """Yield what may be wrong with a part, and whether it is."""
    yield "is not covered", part.type not in (*JOINTS, *ENERGETIC, *CONSTANT, *PLANES, *PAIRS)
    yield "follows a signal with breakpoints, which is not covered", any(x.type not in SIGNALS for x in part.signals)
    axis, rod = getattr(part, "axis", None), part.type == "distance"
    if part.type in JOINTS and not rod:
        yield "has a second point, which is not covered", bool(getattr(part, "point_b", None))
    if rod:
        length = part.length or math.dist(part.point_a, part.point_b)
        yield "is not closed at t = 0", abs(length / math.dist(part.point_a, part.point_b) - 1.0) > ROD_GAP
    if part.type in (*ENERGETIC, *CONSTANT):
        yield "pulls alone, which is not covered", getattr(part, "tension_only", False)
        yield "is along a body's axes, which is not covered", getattr(part, "frame", "world") == "body"
        yield "is about an axis in space, which is not covered", part.type == "torsion_spring" and bool(axis)
        if part.type == "oblateness":
            along = sorted(map(abs, part.axis)) == [0.0, 0.0, 1.0]
            yield "needs a fixed pole along a coordinate axis", part.pole != "fixed" or not along
    if part.type in (*PLANES, *PAIRS):
        yield "is no impact with rebound", part.law.type != "rigid_law" or not part.law.restitution
        sides = {"body_a": "center_a", "body_b": "center_b"} if part.type in PAIRS else {"body_a": "center"}
        if part.type in PLANES:
            ends = part.body_b != GROUND or part.extent not in ("line", "plane") or bool(part.thickness)
            yield "has a surface that moves or ends, which is not covered", ends
        inside = all(places.get(getattr(part, body)) == tuple(getattr(part, side)) for body, side in sides.items())
        yield "has a centre that is not the centre of mass, which is not covered", not inside
