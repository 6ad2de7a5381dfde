"""The numbers of which the vehicle is built, with their origin in scenes/data/tracked_vehicle.json."""

import json
import math
from importlib.resources import files
from typing import Any

from mbs_ref.scene.contact import ConstraintLaw, ContactLaw, ProgressiveLaw, RegularisedCoulomb, SpringDamperLaw

DATA: dict[str, Any] = json.loads((files("mbs_ref.scenes") / "data" / "tracked_vehicle.json").read_text())
PITCH, HEIGHT, TEETH = (DATA[name]["value"] for name in ("pitch", "link_height", "teeth"))
PITCH_RADIUS = PITCH / (2.0 * math.sin(math.pi / TEETH))  # m
APOTHEM = PITCH / (2.0 * math.tan(math.pi / TEETH))  # m
AXLE_HEIGHT = PITCH_RADIUS + 0.5 * HEIGHT  # m, of sprocket and idler above ground
ROLLER_RADIUS = DATA["roller"]["radius"]  # m


def contact_law(kind: str, law: str) -> ContactLaw:
    """Return the law of link_wheel, link_ground or sprocket_pin: the first alone may be a constraint."""
    data = DATA["contact"][kind]
    if law == "constraint" and kind == "link_wheel":
        return ConstraintLaw()
    if law != "spring_damper":
        return ProgressiveLaw(stiffness=data["k"], damping=data["c_progressive"])
    return SpringDamperLaw(stiffness=data["k"], damping=data["c_kv"], release="force")


def friction(coefficient: float) -> RegularisedCoulomb | None:
    """Return friction that creeps where it would stick; None where there is none."""
    if coefficient == 0.0:
        return None
    return RegularisedCoulomb(coefficient=coefficient, speed=DATA["friction_creep"]["value"])
