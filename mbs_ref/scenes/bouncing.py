"""A ball that bounces off a floor by any contact law, and Newton's cradle laid flat."""

from typing import Annotated, Any, Literal, get_args

from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene, contact
from mbs_ref.scene.base.part import NonNegative, Positive

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
            contact.CircleOnCircle(
                name=f"pair{k}", body_a=f"ball{k}", center_a=centers[k], radius_a=RADIUS,
                body_b=f"ball{k + 1}", center_b=centers[k + 1], radius_b=RADIUS, law=chosen,
            )
            for k in range(balls - 1)
        ),
    )  # fmt: skip
