"""The elastic pendulum: a point mass on a spring, without any joint."""

from __future__ import annotations

from mbs_ref.scene import GROUND, PointMass, Scene, SpringDamper
from mbs_ref.scene.base.part import NonNegative, Positive


def build(
    *,
    rest_length: Positive = 1.0,
    mass: Positive = 1.0,
    stiffness: Positive = 100.0,
    damping: NonNegative = 0.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Swing a point mass on a spring, released horizontally from rest at the spring's rest length.

    rest_length (m), mass (kg), stiffness (N/m), damping (N s/m), gravity (m/s^2).
    """
    start = (rest_length, 0.0)
    return Scene(
        name="spring_pendulum",
        description="A point mass on a linear spring, released from rest at the height of the anchor.",
        source="Textbook mechanism; Vitt & Gorelik, J. Tech. Phys. USSR 3 (1933) 294",
        duration=5.0,
        gravity=(0.0, -gravity),
        bodies=(PointMass(name="bob", mass=mass, position=start, velocity=(0.0, 0.0)),),
        loads=(
            SpringDamper(
                name="spring", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=start,
                stiffness=stiffness, damping=damping, rest_length=rest_length,
            ),
        ),
    )  # fmt: skip
