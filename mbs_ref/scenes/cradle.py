"""Newton's cradle laid flat."""

from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnCircle, RigidLaw, SpringDamperLaw

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
    soft = SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    chosen = RigidLaw(restitution=restitution) if law == "rigid" else soft
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
