"""The uncontrolled bicycle: four rigid bodies, two knife-edged wheels that roll without slipping."""

import math
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import Revolute, RollingWheel, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative
from mbs_ref.scenes import read_data

DATA = read_data("bicycle")
GRAVITY = 9.81  # m/s^2


def bicycle(*, speed: NonNegative = 4.6, roll_rate: Annotated[float, Field(ge=-2.0, le=2.0)] = 0.5) -> Scene:
    """Push an upright bicycle that runs straight on, and let it balance itself.

    speed (m/s, forward), roll_rate (rad/s, to the right, about the line through both contacts). Without a roll rate it
    runs on upright: steady motion, about which it is stable from 4.29 to 6.02 m/s.
    """
    up, left, tilt = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), math.radians(DATA["steer_tilt_deg"])
    centres = {name: tuple(body["centre"]) for name, body in DATA["bodies"].items()}
    bodies = [
        SpatialBody(
            name=name, mass=body["mass"], inertia=tuple(body["inertia"]), position=centres[name],
            velocity=(speed, -roll_rate * centres[name][2], 0.0),
            angular_velocity=(roll_rate, speed / centres[name][2] if name.endswith("wheel") else 0.0, 0.0),
        )
        for name, body in DATA["bodies"].items()
    ]  # fmt: skip
    hubs = [(end, centres[f"{end}_wheel"]) for end in ("rear", "front")]
    contacts = [
        RollingWheel(name=f"{end}_contact", body=f"{end}_wheel", point=hub, axis=left, radius=hub[2], normal=up)
        for end, hub in hubs
    ]
    turning = [
        Revolute(name=f"{end}_hub", body_a=f"{end}_frame", body_b=f"{end}_wheel", point=hub, axis=left)
        for end, hub in hubs
    ]
    steer = Revolute(
        name="steer", body_a="rear_frame", body_b="front_frame",
        point=(DATA["wheel_base"] + DATA["trail"], 0.0, 0.0), axis=(-math.sin(tilt), 0.0, math.cos(tilt)),
    )  # fmt: skip
    return Scene(
        name="bicycle",
        description=f"An uncontrolled bicycle at {speed:g} m/s, rolling over at {roll_rate:g} rad/s.",
        source="Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, Table 1; "
        "IFToMM library of computational benchmark problems, Uncontrolled bicycle",
        duration=5.0,
        gravity=(0.0, 0.0, -GRAVITY),
        bodies=tuple(bodies),
        joints=(contacts[0], turning[0], steer, turning[1], contacts[1]),
    )
