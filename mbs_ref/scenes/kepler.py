"""Two bodies on a Kepler orbit of any eccentricity."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import PointMass, Scene
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.celestial import Newton


def build(*, eccentricity: Annotated[float, Field(ge=0.0, le=0.999)] = 0.6, orbits: Positive = 10.0) -> Scene:
    """Follow a test particle around a unit attractor, from the nearest point of an ellipse (Kepler).

    eccentricity (0 to 0.999), orbits (revolutions; the semi-major axis is 1 m and gm 1 m^3/s^2).
    """
    e = eccentricity
    return Scene(
        name="kepler",
        description="A test particle on an ellipse with semi-major axis 1 m about a fixed attractor of 1 m^3/s^2.",
        source="J. Kepler, Astronomia Nova, 1609",
        duration=2.0 * math.pi * orbits,
        gravity=(0.0, 0.0, 0.0),
        bodies=(
            PointMass(name="center", mass=1.0, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)),
            PointMass(
                name="planet", mass=1.0, position=(1.0 - e, 0.0, 0.0),
                velocity=(0.0, math.sqrt((1.0 + e) / (1.0 - e)), 0.0),
            ),
        ),
        loads=(Newton(name="newton", gm=(1.0, 0.0)),),
    )  # fmt: skip
