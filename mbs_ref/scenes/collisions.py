"""Bodies that collide: Newton's cradle laid flat, and two spheres in space."""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.bodies import sphere_inertia
from mbs_ref.scene.contact import CircleOnCircle, SphereOnSphere
from mbs_ref.scenes.bouncing import law_of

RADIUS = 0.05  # m
CRADLE_RUN_UP = 0.0234567  # m, no whole number of steps, so that no engine meets the floor of a step at touch-down


def newtons_cradle(
    *,
    balls: Annotated[int, Field(ge=2, le=1000)] = 5,
    law: Literal["rigid", "spring_damper"] = "rigid",
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0,
    stiffness: Positive = 1e6,
    damping: NonNegative = 0.0,
    gap: NonNegative = 0.001,
    mass: Positive = 1.0,
    speed: Positive = 1.0,
) -> Scene:
    """Throw one disc against a row of equal ones; with a restitution of 1 only the last one leaves.

    balls; law and its restitution, or stiffness (N/m) and damping (N s/m, released at F = 0); gap between
    neighbours (m), mass (kg), speed of the first (m/s).
    """
    chosen = law_of(law, restitution=restitution, stiffness=stiffness, damping=damping, release="force")
    spacing = 2.0 * RADIUS + gap
    centers = [(k * spacing - (CRADLE_RUN_UP if k == 0 else 0.0), 0.0) for k in range(balls)]
    return Scene(
        name="newtons_cradle",
        description=f"{balls} equal discs in a row, the first thrown at the others.",
        source="Textbook; Herrmann and Schmalzle, Am. J. Phys. 49 (1981) 761",
        duration=0.2,
        bodies=tuple(
            PlanarBody(
                name=f"ball{k}", mass=mass, inertia=0.4 * mass * RADIUS**2, position=center,
                velocity=(speed if k == 0 else 0.0, 0.0),
            )
            for k, center in enumerate(centers)
        ),
        contacts=tuple(
            CircleOnCircle(
                name=f"pair{k}", body_a=f"ball{k}", center_a=centers[k], radius_a=RADIUS,
                body_b=f"ball{k + 1}", center_b=centers[k + 1], radius_b=RADIUS, law=chosen,
            )
            for k in range(balls - 1)
        ),
    )  # fmt: skip


RADIUS_A, RADIUS_B = 0.05, 0.08  # m
RUN_UP = 0.0876543  # m, no whole number of steps, so that no engine meets touch-down at the end of a step


def colliding_spheres(
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
    chosen = law_of(law, restitution=restitution, stiffness=stiffness, damping=damping, release="force")
    line = line_of_centres(obliquity, azimuth)
    start = tuple((-(RADIUS_A + RADIUS_B) * line - np.array([RUN_UP, 0.0, 0.0])).tolist())
    return Scene(
        name="colliding_spheres",
        description="A sphere hits another one obliquely, without friction and gravity.",
        source="Whittaker, Analytical Dynamics, sec. 96",
        duration=0.3,
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
    return SpatialBody(name=name, mass=mass, inertia=sphere_inertia(mass, radius), position=position, velocity=velocity)
