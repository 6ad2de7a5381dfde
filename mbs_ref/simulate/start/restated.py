"""A scene restated where a motion has taken it: bodies, and every part's points and directions on them."""

import math
from typing import Any

import numpy as np

from mbs_ref.observables.attachment import Motion
from mbs_ref.scene import GROUND, Distance, PlanarBody, PointMass, RollingWheel, Scene, SpringDamper, TorsionSpring
from mbs_ref.scene.base.attached import Attached
from mbs_ref.scene.base.part import Role, fields_of
from mbs_ref.scene.contact import ContactPart, PinOnSprocket
from mbs_ref.trajectory import Trajectory


def restated(scene: Scene, path: Trajectory, sign: float = 1.0) -> Scene:
    """Return the scene that starts at the last sample of a motion, its velocities times `sign`.

    Springs keep their laws. A bushing is unstrained where it starts, a contact has no history, signals begin anew.
    """
    motion = Motion(scene, path)
    bodies = tuple(_body(body, path, k, sign) for k, body in enumerate(scene.bodies))
    kinds = ("joints", "loads", "contacts", "events")
    parts = {kind: tuple(_part(part, motion) for part in getattr(scene, kind)) for kind in kinds}
    return scene.model_copy(update={"bodies": bodies, **parts})


def _body(body: Any, path: Trajectory, k: int, sign: float) -> Any:
    velocity, turning, orientation = (
        sign * path.velocity[-1, k],
        sign * path.angular_velocity[-1, k],
        path.orientation[-1, k],
    )
    update: dict[str, Any] = {"position": tuple(path.position[-1, k].tolist()), "velocity": tuple(velocity.tolist())}
    if isinstance(body, PlanarBody):
        update |= {"angle": float(orientation), "angular_velocity": float(turning)}
    elif not isinstance(body, PointMass):
        unit = orientation / np.linalg.norm(orientation)
        update |= {"orientation": tuple(unit.tolist()), "angular_velocity": tuple(turning.tolist())}
    return body.model_copy(update=update)


def _part(part: Attached, motion: Motion) -> Attached:
    """Return a joint, load, contact or event with its points and directions on the moved bodies."""
    update: dict[str, Any] = {}
    for name in {*fields_of(type(part), Role.POINT), *fields_of(type(part), Role.DIRECTION)}:
        value = getattr(part, name)
        if value is None or (owner := _owner(part, name)) == GROUND:
            continue
        at = motion.point if name in fields_of(type(part), Role.POINT) else motion.direction
        update[name] = tuple(at(owner, value)[0][-1].tolist())
    return part.model_copy(update=update | _as_strained(part, motion))


def _owner(part: Any, name: str) -> str:
    """Return the body that a point or direction is fixed in; ground where it is the world's."""
    fields = vars(part)
    if "body" in fields:
        turns = name == "axis" and isinstance(part, RollingWheel)
        return part.body if turns or name in ("point", "center") else GROUND
    if name.endswith(("_a", "_b")):
        return fields[f"body{name[-2:]}"]
    first = name == "center" if isinstance(part, ContactPart) else name != "point"
    return fields["body_a" if first else "body_b"]


def _as_strained(part: Any, motion: Motion) -> dict[str, Any]:
    """Return the fields that count from t = 0, counted from the present start instead."""
    if isinstance(part, SpringDamper | Distance):
        name = "length" if isinstance(part, Distance) else "rest_length"
        return {name: math.dist(part.point_a, part.point_b)} if getattr(part, name) is None else {}
    if isinstance(part, PinOnSprocket) and part.axis is None:
        return {"first_seat": part.first_seat + float(motion.angle(part.body_b)[-1])}
    if not isinstance(part, TorsionSpring):
        return {}
    if part.axis is not None:
        turned = motion.angle_about(part.body_a, part.body_b, part.axis)[0]
        return {"rest_angle": (part.rest_angle or 0.0) - float(turned[-1])}
    if part.rest_angle is not None:
        return {}
    drawn = {body.name: getattr(body, "angle", 0.0) for body in motion.scene.bodies}
    return {"rest_angle": drawn.get(part.body_b, 0.0) - drawn.get(part.body_a, 0.0)}
