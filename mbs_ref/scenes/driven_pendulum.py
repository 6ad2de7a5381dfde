"""A pendulum on a moving pivot: the smallest rheonomic scene."""

from __future__ import annotations

import math

from mbs_ref.scene import GROUND, CoordinateDrive, PlanarBody, Prismatic, Revolute, Scene
from mbs_ref.scene.base.part import Positive
from mbs_ref.scene.signals import Harmonic


def build(
    *,
    length: Positive = 1.0,
    mass: Positive = 1.0,
    amplitude: float = 0.2,
    omega: Positive = 5.0,
    angle: float = -1.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Hang a uniform rod from a carriage that is driven to and fro (rheonomic).

    length (m), mass (kg), amplitude (m) and omega (rad/s) of the drive, angle (rad, of the rod from
    the x axis at t = 0), gravity (m/s^2). The carriage starts at rest: x(t) = amplitude (cos(omega t) - 1).
    """
    rod = PlanarBody(
        name="rod", mass=mass, inertia=mass * length**2 / 12.0,
        position=(0.5 * length * math.cos(angle), 0.5 * length * math.sin(angle)), angle=angle,
    )  # fmt: skip
    return Scene(
        name="driven_pendulum",
        description="A uniform rod hinged to a carriage whose motion along x is prescribed.",
        source="Textbook mechanism; Landau & Lifshitz, Mechanics, 3rd ed., section 5, problem 3",
        duration=5.0,
        gravity=(0.0, -gravity),
        bodies=(PlanarBody(name="carriage", mass=1.0, inertia=0.1), rod),
        joints=(
            Prismatic(name="rail", body_a=GROUND, body_b="carriage", point=(0.0, 0.0), axis=(1.0, 0.0)),
            Revolute(name="pivot", body_a="carriage", body_b="rod", point=(0.0, 0.0)),
            CoordinateDrive(
                name="drive", body="carriage", coordinate="x",
                motion=Harmonic(amplitude=amplitude, omega=omega, phase=0.5 * math.pi),
            ),
        ),
    )  # fmt: skip
