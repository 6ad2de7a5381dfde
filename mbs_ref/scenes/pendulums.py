"""Pendulums: on a rod in the plane and in space, on a spring, on a driven pivot, and two in a row."""

import math
from typing import Annotated

from pydantic import Field

from mbs_ref import scene as parts
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.signals import Harmonic


def pendulum(*, length: Positive = 1.0, mass: Positive = 1.0, gravity: Positive = 9.81) -> parts.Scene:
    """Swing a point mass on a massless rod, released horizontally from rest (IFToMM A01).

    length (m), mass (kg), gravity (m/s^2).
    """
    start = (-length, 0.0)
    return parts.Scene(
        name="pendulum",
        description="A point mass at the end of a massless rod, released from rest at the height of the pivot.",
        source="IFToMM Technical Committee for Multibody Dynamics, benchmark library, A01 Simple pendulum",
        duration=10.0,
        gravity=(0.0, -gravity),
        bodies=(parts.PointMass(name="bob", mass=mass, position=start, velocity=(0.0, 0.0)),),
        joints=(
            parts.Distance(
                name="rod", body_a=parts.GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=start, length=length
            ),
        ),
    )


def spherical_pendulum(
    *,
    length: Positive = 1.0,
    gravity: Positive = 9.81,
    angle: Annotated[float, Field(gt=0.0, lt=3.1)] = 1.0,
    speed: Positive = 1.0,
) -> parts.Scene:
    """Swing a point mass on a massless rod, sent off sideways.

    length (m), gravity (m/s^2), angle (rad from straight down), speed (m/s, horizontal).
    """
    start = (length * math.sin(angle), 0.0, -length * math.cos(angle))
    return parts.Scene(
        name="spherical_pendulum",
        description="A point mass at the end of a massless rod in space, started with a horizontal velocity.",
        source="Whittaker, Analytical Dynamics (1904), section 55",
        duration=10.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(parts.PointMass(name="bob", mass=1.0, position=start, velocity=(0.0, speed, 0.0)),),
        joints=(parts.Distance(name="rod", body_a=parts.GROUND, body_b="bob", point_a=(0.0, 0.0, 0.0), point_b=start),),
    )


def spring_pendulum(
    *,
    rest_length: Positive = 1.0,
    mass: Positive = 1.0,
    stiffness: Positive = 100.0,
    damping: NonNegative = 0.0,
    gravity: Positive = 9.81,
) -> parts.Scene:
    """Swing a point mass on a spring, released horizontally from rest at the spring's rest length.

    rest_length (m), mass (kg), stiffness (N/m), damping (N s/m), gravity (m/s^2).
    """
    start = (rest_length, 0.0)
    return parts.Scene(
        name="spring_pendulum",
        description="A point mass on a linear spring, released from rest at the height of the anchor.",
        source="Textbook mechanism; Vitt & Gorelik, J. Tech. Phys. USSR 3 (1933) 294",
        duration=5.0,
        gravity=(0.0, -gravity),
        bodies=(parts.PointMass(name="bob", mass=mass, position=start, velocity=(0.0, 0.0)),),
        loads=(
            parts.SpringDamper(
                name="spring", body_a=parts.GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=start,
                stiffness=stiffness, damping=damping, rest_length=rest_length,
            ),
        ),
    )  # fmt: skip


def driven_pendulum(
    *,
    length: Positive = 1.0,
    mass: Positive = 1.0,
    amplitude: float = 0.2,
    omega: Positive = 5.0,
    angle: float = -1.0,
    gravity: Positive = 9.81,
) -> parts.Scene:
    """Hang a uniform rod from a carriage that is driven to and fro (rheonomic).

    length (m), mass (kg), amplitude (m) and omega (rad/s) of the drive, angle (rad, of the rod from
    the x axis at t = 0), gravity (m/s^2). The carriage starts at rest: x(t) = amplitude (cos(omega t) - 1).
    """
    rod = parts.PlanarBody(
        name="rod", mass=mass, inertia=mass * length**2 / 12.0,
        position=(0.5 * length * math.cos(angle), 0.5 * length * math.sin(angle)), angle=angle,
    )  # fmt: skip
    return parts.Scene(
        name="driven_pendulum",
        description="A uniform rod hinged to a carriage whose motion along x is prescribed.",
        source="Textbook mechanism; Landau & Lifshitz, Mechanics, 3rd ed., section 5, problem 3",
        duration=5.0,
        gravity=(0.0, -gravity),
        bodies=(parts.PlanarBody(name="carriage", mass=1.0, inertia=0.1), rod),
        joints=(
            parts.Prismatic(name="rail", body_a=parts.GROUND, body_b="carriage", point=(0.0, 0.0), axis=(1.0, 0.0)),
            parts.Revolute(name="pivot", body_a="carriage", body_b="rod", point=(0.0, 0.0)),
            parts.CoordinateDrive(
                name="drive", body="carriage", coordinate="x",
                motion=Harmonic(amplitude=amplitude, omega=omega, phase=0.5 * math.pi),
            ),
        ),
    )  # fmt: skip


def double_pendulum(
    *,
    length_1: Positive = 1.0,
    length_2: Positive = 0.8,
    mass_1: Positive = 1.0,
    mass_2: Positive = 0.6,
    angle_1: float = 0.0,
    angle_2: float = 0.5,
    gravity: Positive = 9.81,
) -> parts.Scene:
    """Release two hinged uniform rods from rest.

    length_1, length_2 (m), mass_1, mass_2 (kg), angle_1, angle_2 (rad, from the x axis), gravity (m/s^2).
    """
    elbow = (length_1 * math.cos(angle_1), length_1 * math.sin(angle_1))
    middle = (elbow[0] + 0.5 * length_2 * math.cos(angle_2), elbow[1] + 0.5 * length_2 * math.sin(angle_2))
    upper = parts.PlanarBody(
        name="upper", mass=mass_1, inertia=mass_1 * length_1**2 / 12.0,
        position=(0.5 * elbow[0], 0.5 * elbow[1]), angle=angle_1,
    )  # fmt: skip
    lower = parts.PlanarBody(
        name="lower", mass=mass_2, inertia=mass_2 * length_2**2 / 12.0, position=middle, angle=angle_2
    )
    return parts.Scene(
        name="double_pendulum",
        description="Two unlike uniform rods in a row, released from rest; chaotic in the long run.",
        source="Textbook mechanism; Levien & Tan, Am. J. Phys. 61 (1993) 1038, for the compound form",
        duration=3.0,
        gravity=(0.0, -gravity),
        bodies=(upper, lower),
        joints=(
            parts.Revolute(name="shoulder", body_a=parts.GROUND, body_b="upper", point=(0.0, 0.0)),
            parts.Revolute(name="elbow", body_a="upper", body_b="lower", point=elbow),
        ),
    )
