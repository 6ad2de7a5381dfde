"""A point mass on a rod in space."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import GROUND, Distance, PointMass, Scene
from mbs_ref.scene.base.part import Positive


def build(
    *,
    length: Positive = 1.0,
    gravity: Positive = 9.81,
    angle: Annotated[float, Field(gt=0.0, lt=3.1)] = 1.0,
    speed: Positive = 1.0,
) -> Scene:
    """Swing a point mass on a massless rod, sent off sideways.

    length (m), gravity (m/s^2), angle (rad from straight down), speed (m/s, horizontal).
    """
    start = (length * math.sin(angle), 0.0, -length * math.cos(angle))
    return Scene(
        name="spherical_pendulum",
        description="A point mass at the end of a massless rod in space, started with a horizontal velocity.",
        source="Whittaker, Analytical Dynamics (1904), section 55",
        duration=10.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(PointMass(name="bob", mass=1.0, position=start, velocity=(0.0, speed, 0.0)),),
        joints=(Distance(name="rod", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0, 0.0), point_b=start),),
    )
