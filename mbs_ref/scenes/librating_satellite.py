"""A satellite with an extent: the gravity gradient turns it, and about the local vertical it librates."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import PointMass, Scene, SpatialBody
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.celestial import GravityGradient, Newton
from mbs_ref.scene.euler_parameters import from_axis_angle
from mbs_ref.scenes.satellite import GM_EARTH, MASS, R_EARTH

EARTH_MASS = 5.9722e24  # kg, IAU 2015


def build(
    *,
    pitch: Annotated[float, Field(gt=-90.0, lt=90.0)] = 30.0,
    eccentricity: Annotated[float, Field(ge=0.0, lt=0.7)] = 0.0,
    altitude: Positive = 4.0e5,
    yaw_inertia: Positive = 40.0,
    roll_inertia: Positive = 160.0,
    pitch_inertia: Positive = 180.0,
    orbits: Annotated[float, Field(gt=0.0, le=100.0)] = 2.0,
) -> Scene:
    """Release a rigid satellite, turned from the local vertical about the normal of its orbit (Fox 2001).

    pitch (deg, from the vertical, at the orbit's own rate), eccentricity, altitude of the perigee (m), yaw_inertia,
    roll_inertia and pitch_inertia (kg m^2, about the vertical, the flight direction and the normal of the orbit),
    orbits (duration). The Earth is a point mass at rest; the satellite has Euler parameters.
    """
    radius = R_EARTH + altitude
    axis = radius / (1.0 - eccentricity)
    speed = math.sqrt(GM_EARTH / axis * (1.0 + eccentricity) / (1.0 - eccentricity))
    turned = from_axis_angle((0.0, 0.0, 1.0), math.radians(pitch))
    return Scene(
        name="librating_satellite",
        description=f"A rigid satellite librates about the local vertical, released at {pitch:g} degrees.",
        source="J. Wertz, Spacecraft Attitude Determination and Control, 1978, sec. 17.2; V. Beletsky 1965",
        duration=orbits * 2.0 * math.pi * math.sqrt(axis**3 / GM_EARTH),
        gravity=(0.0, 0.0, 0.0),
        bodies=(
            PointMass(name="earth", mass=EARTH_MASS, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)),
            SpatialBody(
                name="satellite", mass=MASS, inertia=(yaw_inertia, roll_inertia, pitch_inertia, 0.0, 0.0, 0.0),
                position=(radius, 0.0, 0.0), velocity=(0.0, speed, 0.0), orientation=tuple(turned.tolist()),
                angular_velocity=(0.0, 0.0, speed / radius),
            ),
        ),
        loads=(
            Newton(name="newton", gm=(GM_EARTH, 0.0)),
            GravityGradient(name="gradient", body="satellite", planet="earth", gm=GM_EARTH),
        ),
    )  # fmt: skip
