"""The compound double pendulum: two hinged rods, the smallest chaotic mechanism."""

from __future__ import annotations

import math

from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene
from mbs_ref.scene.base.part import Positive


def build(
    *,
    length_1: Positive = 1.0,
    length_2: Positive = 0.8,
    mass_1: Positive = 1.0,
    mass_2: Positive = 0.6,
    angle_1: float = 0.0,
    angle_2: float = 0.5,
    gravity: Positive = 9.81,
) -> Scene:
    """Release two hinged uniform rods from rest.

    length_1, length_2 (m), mass_1, mass_2 (kg), angle_1, angle_2 (rad, from the x axis), gravity (m/s^2).
    """
    elbow = (length_1 * math.cos(angle_1), length_1 * math.sin(angle_1))
    middle = (elbow[0] + 0.5 * length_2 * math.cos(angle_2), elbow[1] + 0.5 * length_2 * math.sin(angle_2))
    upper = PlanarBody(
        name="upper", mass=mass_1, inertia=mass_1 * length_1**2 / 12.0,
        position=(0.5 * elbow[0], 0.5 * elbow[1]), angle=angle_1,
    )  # fmt: skip
    lower = PlanarBody(name="lower", mass=mass_2, inertia=mass_2 * length_2**2 / 12.0, position=middle, angle=angle_2)
    return Scene(
        name="double_pendulum",
        description="Two unlike uniform rods in a row, released from rest; chaotic in the long run.",
        source="Textbook mechanism; Levien & Tan, Am. J. Phys. 61 (1993) 1038, for the compound form",
        duration=3.0,
        gravity=(0.0, -gravity),
        bodies=(upper, lower),
        joints=(
            Revolute(name="shoulder", body_a=GROUND, body_b="upper", point=(0.0, 0.0)),
            Revolute(name="elbow", body_a="upper", body_b="lower", point=elbow),
        ),
    )
