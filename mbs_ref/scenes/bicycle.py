"""The uncontrolled bicycle: four rigid bodies, two knife-edged wheels that roll without slipping."""

import math
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import Revolute, RollingWheel, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative

# Table 1 of the source, its axes x forward, y right, z down turned to x forward, y left, z up: products xz change sign
WHEEL_BASE, TRAIL = 1.02, 0.08  # m
STEER_TILT = math.pi / 10.0  # rad, of the steer axis, back from the vertical
GRAVITY = 9.81  # m/s^2
REAR_RADIUS, FRONT_RADIUS = 0.3, 0.35  # m
REAR_MASS, FRONT_MASS, FRAME_MASS, FORK_MASS = 2.0, 3.0, 85.0, 4.0  # kg
REAR_INERTIA = (0.0603, 0.12, 0.0603, 0.0, 0.0, 0.0)  # kg m^2: xx, yy, zz, xy, xz, yz
FRONT_INERTIA = (0.1405, 0.28, 0.1405, 0.0, 0.0, 0.0)  # kg m^2
FRAME_INERTIA = (9.2, 11.0, 2.8, 0.0, -2.4, 0.0)  # kg m^2, rear frame with the rider
FORK_INERTIA = (0.05892, 0.06, 0.00708, 0.0, 0.00756, 0.0)  # kg m^2, front frame
FRAME_CENTRE, FORK_CENTRE = (0.3, 0.0, 0.9), (0.9, 0.0, 0.7)  # m, from the rear contact


def bicycle(*, speed: NonNegative = 4.6, roll_rate: Annotated[float, Field(ge=-2.0, le=2.0)] = 0.5) -> Scene:
    """Push an upright bicycle that runs straight on, and let it balance itself.

    speed (m/s, forward), roll_rate (rad/s, to the right, about the line through both contacts). Without a roll rate it
    runs on upright: steady motion, about which it is stable from 4.29 to 6.02 m/s.
    """
    up, left = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
    rear, front = (0.0, 0.0, REAR_RADIUS), (WHEEL_BASE, 0.0, FRONT_RADIUS)
    steer = (-math.sin(STEER_TILT), 0.0, math.cos(STEER_TILT))

    def body(name: str, mass: float, inertia, centre, spin: float = 0.0) -> SpatialBody:
        return SpatialBody(
            name=name, mass=mass, inertia=inertia, position=centre,
            velocity=(speed, -roll_rate * centre[2], 0.0), angular_velocity=(roll_rate, spin, 0.0),
        )  # fmt: skip

    return Scene(
        name="bicycle",
        description=f"An uncontrolled bicycle at {speed:g} m/s, rolling over at {roll_rate:g} rad/s.",
        source="Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, Table 1; "
        "IFToMM library of computational benchmark problems, Uncontrolled bicycle",
        duration=5.0,
        gravity=(0.0, 0.0, -GRAVITY),
        bodies=(
            body("rear_wheel", REAR_MASS, REAR_INERTIA, rear, speed / REAR_RADIUS),
            body("rear_frame", FRAME_MASS, FRAME_INERTIA, FRAME_CENTRE),
            body("front_frame", FORK_MASS, FORK_INERTIA, FORK_CENTRE),
            body("front_wheel", FRONT_MASS, FRONT_INERTIA, front, speed / FRONT_RADIUS),
        ),
        joints=(
            RollingWheel(
                name="rear_contact", body="rear_wheel", point=rear, axis=left, radius=REAR_RADIUS, normal=up
            ),
            Revolute(name="rear_hub", body_a="rear_frame", body_b="rear_wheel", point=rear, axis=left),
            Revolute(
                name="steer", body_a="rear_frame", body_b="front_frame",
                point=(WHEEL_BASE + TRAIL, 0.0, 0.0), axis=steer,
            ),
            Revolute(name="front_hub", body_a="front_frame", body_b="front_wheel", point=front, axis=left),
            RollingWheel(
                name="front_contact", body="front_wheel", point=front, axis=left, radius=FRONT_RADIUS, normal=up
            ),
        ),
    )  # fmt: skip
