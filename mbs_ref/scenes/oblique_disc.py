"""A disc thrown obliquely at rough ground."""

from __future__ import annotations

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnLine, SpringDamperLaw, StickSlip

RADIUS = 0.1  # m


def build(
    *,
    speed_down: Positive = 1.0,
    speed_along: float = 3.0,
    friction: NonNegative = 0.2,
    mass: Positive = 1.0,
    stiffness: Positive = 1e5,
    damping: NonNegative = 100.0,
) -> Scene:
    """Throw a disc obliquely; while it slides all along, friction takes mu (1 + e) v_n from v_t.

    speed_down and speed_along (m/s), friction (mu), mass (kg), contact stiffness (N/m) and damping (N s/m).
    """
    center = (0.0, RADIUS + 0.1)
    return Scene(
        name="oblique_disc",
        description="A disc hits rough ground obliquely, without gravity.",
        source="Textbook; Whittaker, Analytical Dynamics, sec. 95",
        duration=0.3,
        bodies=(
            PlanarBody(
                name="disc", mass=mass, inertia=0.5 * mass * RADIUS**2, position=center,
                velocity=(speed_along, -speed_down),
            ),
        ),
        contacts=(
            CircleOnLine(
                name="ground", body_a="disc", center=center, radius=RADIUS, point_1=(0.0, 0.0), point_2=(1.0, 0.0),
                law=SpringDamperLaw(stiffness=stiffness, damping=damping),
                friction=StickSlip(coefficient=friction, stiffness=stiffness),
            ),
        ),
    )  # fmt: skip
