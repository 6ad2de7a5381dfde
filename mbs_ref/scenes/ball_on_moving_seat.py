"""A ball dropped on a finite seat that moves and turns."""

from __future__ import annotations

from typing import Literal

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnLine, ContactLaw, ProgressiveLaw, RegularisedCoulomb, SpringDamperLaw

RADIUS = 0.05  # m


def build(
    *,
    law: Literal["spring_damper", "progressive"] = "spring_damper",
    stiffness: Positive = 1e4,
    damping: NonNegative = 10.0,
    friction: NonNegative = 0.3,
    offset: float = 0.3,
    seat_mass: Positive = 3.0,
    spin: float = 0.2,
) -> Scene:
    """Throw a ball on a free, turning seat with round ends; momentum is kept to roundoff.

    contact law, stiffness (N/m), damping (N s/m, or N s/m^2 if progressive), friction (mu), where the ball
    starts along the seat (m, from its middle; the seat ends at 0.5), mass (kg) and spin (rad/s) of the seat.
    """
    kinds = {"spring_damper": SpringDamperLaw, "progressive": ProgressiveLaw}
    chosen: ContactLaw = kinds[law](stiffness=stiffness, damping=damping)
    start = (offset, RADIUS + 0.1)
    return Scene(
        name="ball_on_moving_seat",
        description="A ball meets a finite surface on a body that moves and turns.",
        source="Momentum balance",
        duration=1.0,
        bodies=(
            PlanarBody(name="ball", mass=1.0, inertia=0.001, position=start, velocity=(0.3, -1.0)),
            PlanarBody(name="seat", mass=seat_mass, inertia=0.5, position=(0.0, -0.1), angular_velocity=spin),
        ),
        contacts=(
            CircleOnLine(
                name="seat", body_a="ball", center=start, radius=RADIUS, body_b="seat", point_1=(-0.5, 0.0),
                point_2=(0.5, 0.0), extent="capped", law=chosen,
                friction=RegularisedCoulomb(coefficient=friction, speed=0.05) if friction else None,
            ),
        ),
    )  # fmt: skip
