"""Two smooth spheres collide obliquely in space."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import ContactLaw, RigidLaw, SphereOnSphere, SpringDamperLaw
from mbs_ref.scene.inertia import sphere

RADIUS_A, RADIUS_B = 0.05, 0.08  # m
RUN_UP = 0.0876543  # m, no whole number of steps, so that no engine meets touch-down at the end of a step


def build(
    *,
    law: Literal["rigid", "spring_damper"] = "rigid",
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] = 0.8,
    stiffness: Positive = 1e5,
    damping: NonNegative = 0.0,
    speed: Positive = 1.0,
    obliquity: Annotated[float, Field(ge=0.0, lt=1.5)] = 0.6,
    azimuth: float = 0.9,
    mass_a: Positive = 1.0,
    mass_b: Positive = 2.0,
) -> Scene:
    """Throw one sphere at another at rest; at touch-down the line of centres is oblique to the velocity.

    law and its restitution, or stiffness (N/m) and damping (N s/m, released at F = 0); speed of the first (m/s,
    along x), angle of the line of centres to it and azimuth of that line about x (rad), masses (kg).
    """
    rigid = law == "rigid"
    chosen: ContactLaw = (
        RigidLaw(restitution=restitution)
        if rigid
        else SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    )
    line = line_of_centres(obliquity, azimuth)
    start = tuple((-(RADIUS_A + RADIUS_B) * line - np.array([RUN_UP, 0.0, 0.0])).tolist())
    return Scene(
        name="colliding_spheres",
        description="A sphere hits another one obliquely, without friction and gravity.",
        source="Whittaker, Analytical Dynamics, sec. 96",
        duration=0.3,
        gravity=(0.0, 0.0, 0.0),
        bodies=(
            _sphere("a", mass_a, RADIUS_A, start, (speed, 0.0, 0.0)),
            _sphere("b", mass_b, RADIUS_B, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ),
        contacts=(
            SphereOnSphere(
                name="pair", body_a="a", center_a=start, radius_a=RADIUS_A, body_b="b", center_b=(0.0, 0.0, 0.0),
                radius_b=RADIUS_B, law=chosen,
            ),
        ),
    )  # fmt: skip


def line_of_centres(obliquity: float, azimuth: float) -> np.ndarray:
    """Return the unit vector (3,) from a to b at touch-down."""
    across = math.sin(obliquity)
    return np.array([math.cos(obliquity), across * math.cos(azimuth), across * math.sin(azimuth)])


def _sphere(name: str, mass: float, radius: float, position, velocity) -> SpatialBody:
    return SpatialBody(name=name, mass=mass, inertia=sphere(mass, radius), position=position, velocity=velocity)
