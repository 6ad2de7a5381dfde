"""A ball thrown onto a floor: one bounce by any contact law, with a closed form for most."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import (
    CircleOnLine,
    ContactLaw,
    FloresLaw,
    HuntCrossleyLaw,
    LankaraniNikraveshLaw,
    ProgressiveLaw,
    RigidLaw,
    SpringDamperLaw,
)

Law = Literal[
    "spring_damper", "spring_damper_force", "progressive", "hunt_crossley", "lankarani_nikravesh", "flores", "rigid"
]
RADIUS = 0.05  # m


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
    duration: Positive = 0.4,
) -> Scene:
    """Bounce a ball off a floor by a chosen contact law.

    law; stiffness (N/m^n), damping (N s/m, or N s/m^(n + 1) where the law multiplies it by d^n), exponent
    n of the power laws, nominal restitution; mass (kg), height above the floor (m), speed downwards
    (m/s), gravity (m/s^2; 0 leaves a single free impact), thickness of the floor if it is a plate (m; 0 is
    endless: deeper than a plate is behind it), duration (s). ValueError for a ball that lies on a rigid floor.
    """
    if law == "rigid" and gravity > 0.0 and height == 0.0 and speed == 0.0:
        raise ValueError("bouncing_ball: law = 'rigid' has impacts alone and bears no weight; give a height or a speed")
    return Scene(
        name="bouncing_ball",
        description=f"A ball falls on a floor with the {law} contact law.",
        source="Fox 1999 eqs 18 and 33; Hunt and Crossley 1975; Lankarani and Nikravesh 1990; Flores et al. 2011",
        duration=duration,
        gravity=(0.0, -gravity),
        bodies=(
            PlanarBody(
                name="ball", mass=mass, inertia=0.4 * mass * RADIUS**2,
                position=(0.0, RADIUS + height), velocity=(0.0, -speed),
            ),
        ),
        contacts=(
            CircleOnLine(
                name="floor", body_a="ball", center=(0.0, RADIUS + height), radius=RADIUS,
                point_1=(-1.0, 0.0), point_2=(1.0, 0.0), law=_law(law, stiffness, damping, exponent, restitution),
                thickness=plate or None,
            ),
        ),
    )  # fmt: skip


def _law(law: Law, stiffness: float, damping: float, exponent: float, restitution: float) -> ContactLaw:
    laws: dict[str, ContactLaw] = {
        "spring_damper": SpringDamperLaw(stiffness=stiffness, damping=damping),
        "spring_damper_force": SpringDamperLaw(stiffness=stiffness, damping=damping, release="force"),
        "progressive": ProgressiveLaw(stiffness=stiffness, damping=damping),
        "hunt_crossley": HuntCrossleyLaw(stiffness=stiffness, damping=damping, exponent=exponent),
        "lankarani_nikravesh": LankaraniNikraveshLaw(stiffness=stiffness, restitution=restitution, exponent=exponent),
        "flores": FloresLaw(stiffness=stiffness, restitution=restitution, exponent=exponent),
        "rigid": RigidLaw(restitution=restitution),
    }
    return laws[law]
