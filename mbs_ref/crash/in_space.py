"""The simplified android in space: the planar one's parts with balls for hinges, and a pulse that may come obliquely.

Every number of the planar model is unchanged, so that a crash along x moves in the plane as it does there. Further data
are estimates: moments of inertia about the other axes, and the torques that bring a joint back into the plane.
"""

import math
from typing import Any

import numpy as np

from mbs_ref.scene import Bushing, Force, PlanarBody, Scene, SpatialBody, Spherical, SpringDamper, TorsionSpring, Weld
from mbs_ref.scene.contact import CircleOnCircle, CircleOnLine, SphereOnPlane, SphereOnSphere

UNSTRAINED = 1e-12  # rad
SLENDER = 0.25  # of the planar moment of inertia, about a part's long axis: an estimate
ALONG_X = {"foot"}  # parts whose long axis is x at a straight stand; the others' is y
# m, how far left and right of the plane the two limbs lie whose sum a part is: estimates
APART = {"thigh": 0.09, "lower_leg": 0.09, "foot": 0.09, "upper_arm": 0.19, "lower_arm": 0.19, "hand": 0.19}


def in_space(planar: Scene, name: str, description: str, oblique: float, breadth: float = 0.0) -> Scene:
    """Return a planar android's scene in space, its pulse turned by `oblique` (rad) from x towards z.

    `breadth` (m, along z) is that of surfaces with ends, undefined in the plane; with 0 they are refused.
    """
    angle = {body.name: body.angle for body in planar.bodies if isinstance(body, PlanarBody)}
    place: dict[str, Any] = {joint.name: joint for joint in planar.joints}
    return Scene(
        name=name,
        description=description,
        source=f"{planar.source}; moments about x and y and torques out of the plane are estimates",
        duration=planar.duration,
        gravity=_lifted(planar.gravity),
        bodies=tuple(_body(body) for body in planar.bodies),
        joints=tuple(_joint(joint) for joint in planar.joints),
        loads=tuple(part for load in planar.loads for part in _loads(load, angle, place, oblique)),
        contacts=tuple(_contact(contact, breadth) for contact in planar.contacts),
    )


def _lifted(vector: Any) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), 0.0


def _body(body: Any) -> SpatialBody:
    slim = SLENDER * body.inertia
    long_x, long_y = (slim, body.inertia) if body.name in ALONG_X else (body.inertia, slim)
    spread = body.mass * APART.get(body.name, 0.0) ** 2
    half = 0.5 * body.angle
    return SpatialBody(
        name=body.name, mass=body.mass, inertia=(long_x + spread, long_y + spread, body.inertia, 0.0, 0.0, 0.0),
        position=_lifted(body.position), orientation=(math.cos(half), 0.0, 0.0, math.sin(half)),
    )  # fmt: skip


def _joint(joint: Any) -> Spherical | Weld:
    kind = Weld if isinstance(joint, Weld) else Spherical
    return kind(name=joint.name, body_a=joint.body_a, body_b=joint.body_b, point=_lifted(joint.point))


def _loads(load: Any, angle: dict[str, float], place: dict[str, Any], oblique: float) -> list[Any]:
    if isinstance(load, Force):
        along, across = load.vector[0] * math.cos(oblique), load.vector[0] * math.sin(oblique)
        turned = (along, load.vector[1], across)
        return [Force(name=load.name, body=load.body, point=_lifted(load.point), vector=turned, factor=load.factor)]
    if isinstance(load, SpringDamper):
        marks: dict[str, Any] = {"point_a": _lifted(load.point_a), "point_b": _lifted(load.point_b)}
        return [SpringDamper(**dict(load) | marks)]
    if isinstance(load, TorsionSpring):
        return [_restoring(load, angle, place[load.name.removesuffix(".restoring")])]
    raise ValueError(f"load {load.name!r} of type {load.type} has no counterpart in space yet")


def _restoring(load: TorsionSpring, angle: dict[str, float], joint: Any) -> Bushing:
    """Return a torque against the rotation vector: the plane's about z, as stiff about every other axis."""
    start = angle[load.body_b] - angle[load.body_a]
    if load.rest_angle is not None and abs(load.rest_angle - start) > UNSTRAINED:
        raise ValueError(f"load {load.name!r} is strained at t = 0, and has no counterpart in space yet")
    k, c, none = load.stiffness, load.damping, (0.0, 0.0, 0.0)
    return Bushing(
        name=load.name, body_a=load.body_a, body_b=load.body_b, point=_lifted(joint.point),
        stiffness=(*none, k, k, k), damping=(*none, c, c, c),
    )  # fmt: skip


def _contact(contact: Any, breadth: float) -> SphereOnPlane | SphereOnSphere:
    ends: dict[str, Any] = {
        "name": contact.name, "body_a": contact.body_a, "body_b": contact.body_b, "law": contact.law,
    }  # fmt: skip
    if isinstance(contact, CircleOnCircle):
        centers: dict[str, Any] = {"center_a": _lifted(contact.center_a), "center_b": _lifted(contact.center_b)}
        return SphereOnSphere(**ends, **centers, radius_a=contact.radius_a, radius_b=contact.radius_b)
    if not isinstance(contact, CircleOnLine) or (contact.extent != "line" and not breadth > 0.0):
        raise ValueError(f"contact {contact.name!r} of type {contact.type} has no counterpart in space yet")
    first, second = np.array(contact.point_1), np.array(contact.point_2)
    across, along = (second - first).tolist()
    plane: dict[str, Any] = {"normal": (-along, across, 0.0), "thickness": contact.thickness}
    ball: dict[str, Any] = {"center": _lifted(contact.center), "radius": contact.radius}
    if contact.extent == "line":
        return SphereOnPlane(**ends, **ball, **plane, point=_lifted(first))
    return SphereOnPlane(
        **ends, **ball, **plane, point=_lifted(0.5 * (first + second)), edge=_lifted((across, along)),
        size=(math.hypot(across, along), breadth), extent="capped" if contact.extent == "capped" else "rectangle",
    )  # fmt: skip
