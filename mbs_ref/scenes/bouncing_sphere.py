"""A sphere thrown onto a tilted floor in space: one bounce by any contact law, as in the plane."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import SphereOnPlane
from mbs_ref.scene.inertia import sphere
from mbs_ref.scenes import bouncing_ball
from mbs_ref.scenes.bouncing_ball import RADIUS, Law


def build(
    *,
    law: Law = "spring_damper",
    stiffness: Positive = 1e4,
    damping: NonNegative = 40.0,
    exponent: Annotated[float, Field(ge=1.0, le=3.0)] = 1.5,
    restitution: Annotated[float, Field(gt=0.0, le=1.0)] = 0.5,
    mass: Positive = 1.0,
    height: NonNegative = 0.1,
    speed: NonNegative = 1.0,
    gravity: NonNegative = 0.0,
    plate: NonNegative = 0.0,
    tilt: Annotated[float, Field(ge=0.0, lt=1.5)] = 0.4,
    heading: float = 0.7,
    duration: Positive = 0.4,
) -> Scene:
    """Bounce a sphere off a tilted floor by a chosen contact law.

    law; stiffness (N/m^n), damping (N s/m, or N s/m^(n + 1) where the law multiplies it by d^n), exponent
    n of the power laws, nominal restitution; mass (kg), height above the floor (m), speed towards it (m/s),
    gravity towards it (m/s^2; 0 leaves a single free impact), thickness of the floor if it is a plate (m; 0 is
    endless), tilt of the floor's normal from z and its heading about z (rad), duration (s).
    """
    plane = bouncing_ball.build(
        law=law, stiffness=stiffness, damping=damping, exponent=exponent, restitution=restitution
    )
    normal = floor_normal(tilt, heading)
    center = tuple(((RADIUS + height) * normal).tolist())
    return Scene(
        name="bouncing_sphere",
        description=f"A sphere falls on a tilted floor with the {law} contact law.",
        source=plane.source,
        duration=duration,
        gravity=tuple((-gravity * normal).tolist()),
        bodies=(
            SpatialBody(
                name="ball", mass=mass, inertia=sphere(mass, RADIUS), position=center,
                velocity=tuple((-speed * normal).tolist()),
            ),
        ),
        contacts=(
            SphereOnPlane(
                name="floor", body_a="ball", center=center, radius=RADIUS, point=(0.0, 0.0, 0.0),
                normal=tuple(normal.tolist()), law=plane.contacts[0].law, thickness=plate or None,
            ),
        ),
    )  # fmt: skip


def floor_normal(tilt: float, heading: float) -> np.ndarray:
    """Return the floor's unit normal (3,)."""
    across = math.sin(tilt)
    return np.array([across * math.cos(heading), across * math.sin(heading), math.cos(tilt)])
