"""A disc that bounces between two walls."""

from __future__ import annotations

from typing import Literal

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.contact import CircleOnLine, ContactLaw, RigidLaw, SpringDamperLaw

RADIUS, WIDTH = 0.1, 1.0  # m


def build(
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
    chosen: ContactLaw = RigidLaw(restitution=1.0) if law == "rigid" else SpringDamperLaw(stiffness=stiffness)
    walls = {"left": (0.0, 1.0, 0.0), "right": (WIDTH, 0.0, 1.0)}  # m: x, then y from and to
    return Scene(
        name="disc_between_walls",
        description="A disc bounces between two walls without loss.",
        source="Textbook",
        duration=2.0,
        bodies=(
            PlanarBody(
                name="disc", mass=mass, inertia=0.5 * mass * RADIUS**2, position=(0.5 * WIDTH, 0.0),
                velocity=(speed, 0.0),
            ),
        ),
        contacts=tuple(
            CircleOnLine(
                name=name, body_a="disc", center=(0.5 * WIDTH, 0.0), radius=RADIUS, point_1=(x, y1), point_2=(x, y2),
                law=chosen,
            )
            for name, (x, y1, y2) in walls.items()
        ),
    )  # fmt: skip
