"""A body that bounces off a floor or between walls, by any contact law, in the plane and in space."""

import math
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene, SpatialBody, contact
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.bodies import sphere_inertia

Law = Literal[
    "spring_damper", "spring_damper_force", "progressive", "hunt_crossley", "lankarani_nikravesh", "flores", "rigid"
]
LAWS = {law.model_fields["type"].default: law for law in get_args(get_args(contact.ContactLaw)[0])}
RADIUS = 0.05  # m
SOURCE = "Fox 1999 eqs 18 and 33; Hunt and Crossley 1975; Lankarani and Nikravesh 1990; Flores et al. 2011"


def bouncing_ball(
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
    endless: deeper than a plate is behind it), duration (s). ValueError for a ball that rests on a rigid floor, e = 1.
    """
    chosen = law_of(law, stiffness=stiffness, damping=damping, exponent=exponent, restitution=restitution)
    if law == "rigid" and restitution == 1.0 and gravity > 0.0 and height == 0.0 and speed == 0.0:
        raise ValueError("bouncing_ball: a ball that never loses speed does not rest; give a height or a speed")
    return Scene(
        name="bouncing_ball",
        description=f"A ball falls on a floor with the {law} contact law.",
        source=SOURCE,
        duration=duration,
        gravity=(0.0, -gravity),
        bodies=(
            PlanarBody(
                name="ball", mass=mass, inertia=0.4 * mass * RADIUS**2,
                position=(0.0, RADIUS + height), velocity=(0.0, -speed),
            ),
        ),
        contacts=(
            contact.CircleOnLine(
                name="floor", body_a="ball", center=(0.0, RADIUS + height), radius=RADIUS,
                point_1=(-1.0, 0.0), point_2=(1.0, 0.0), law=chosen, thickness=plate or None,
            ),
        ),
    )  # fmt: skip


def law_of(kind: str, **numbers: Any) -> contact.ContactLaw:
    """Return the contact law of a kind with those of the numbers that it has; `kind`_force releases at F = 0."""
    if kind.endswith("_force"):
        return law_of(kind.removesuffix("_force"), **numbers, release="force")
    law = LAWS[f"{kind}_law"]
    return law(**{name: number for name, number in numbers.items() if name in law.model_fields})


def bouncing_sphere(
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
    chosen = law_of(law, stiffness=stiffness, damping=damping, exponent=exponent, restitution=restitution)
    normal = floor_normal(tilt, heading)
    center = tuple(((RADIUS + height) * normal).tolist())
    return Scene(
        name="bouncing_sphere",
        description=f"A sphere falls on a tilted floor with the {law} contact law.",
        source=SOURCE,
        duration=duration,
        gravity=tuple((-gravity * normal).tolist()),
        bodies=(
            SpatialBody(
                name="ball", mass=mass, inertia=sphere_inertia(mass, RADIUS), position=center,
                velocity=tuple((-speed * normal).tolist()),
            ),
        ),
        contacts=(
            contact.SphereOnPlane(
                name="floor", body_a="ball", center=center, radius=RADIUS, point=(0.0, 0.0, 0.0),
                normal=tuple(normal.tolist()), law=chosen, thickness=plate or None,
            ),
        ),
    )  # fmt: skip


def floor_normal(tilt: float, heading: float) -> np.ndarray:
    """Return the floor's unit normal (3,)."""
    across = math.sin(tilt)
    return np.array([across * math.cos(heading), across * math.sin(heading), math.cos(tilt)])


DISC_RADIUS, WALL_DISTANCE = 0.1, 1.0  # m


def disc_between_walls(
    *,
    law: Literal["spring", "rigid"] = "spring",
    stiffness: Positive = 1e5,
    speed: Positive = 5.0,
    mass: Positive = 1.0,
) -> Scene:
    """Bounce a disc without loss: its energy stays, and the period is exact.

    law: an undamped spring of the stiffness (N/m), or rigid; speed (m/s), mass (kg). A period lasts
    2 ((width - 2 r)/v + pi sqrt(m/k)).
    """
    chosen = law_of("spring_damper" if law == "spring" else law, stiffness=stiffness, restitution=1.0)
    walls = {"left": (0.0, 1.0, 0.0), "right": (WALL_DISTANCE, 0.0, 1.0)}  # m: x, then y from and to
    return Scene(
        name="disc_between_walls",
        description="A disc bounces between two walls without loss.",
        source="Textbook",
        duration=2.0,
        bodies=(
            PlanarBody(
                name="disc", mass=mass, inertia=0.5 * mass * DISC_RADIUS**2, position=(0.5 * WALL_DISTANCE, 0.0),
                velocity=(speed, 0.0),
            ),
        ),
        contacts=tuple(
            contact.CircleOnLine(
                name=name, body_a="disc", center=(0.5 * WALL_DISTANCE, 0.0), radius=DISC_RADIUS,
                point_1=(x, y1), point_2=(x, y2), law=chosen,
            )
            for name, (x, y1, y2) in walls.items()
        ),
    )  # fmt: skip
