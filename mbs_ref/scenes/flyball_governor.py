"""The stiff flyball governor, problem A05 of the IFToMM benchmark library."""

# Vectors are built as tuples of floats whose length the checker cannot see.
# pyright: reportArgumentType=false

import math

from mbs_ref.scene import GROUND, Prismatic, Revolute, Scene, SpatialBody, SpringDamper
from mbs_ref.scene.base.part import NonNegative

DENSITY = 3000.0  # kg/m^3
LENGTH, THICKNESS, EDGE = 1.0, 0.01, 0.1  # m: shaft and rods are 1 x 0.01 x 0.01, the slider a cube
BALL = 5.0  # kg, a point mass at the free end of each rod
STIFFNESS, DAMPING, REST = 8e5, 4e4, 0.5  # N/m, N s/m, m; circulating variants soften both by 1e5
SLIDER_HEIGHT = 0.5  # m, s of the benchmark, above the foot of the shaft
DROOP = math.radians(30.0)  # alpha of the benchmark: rods below the horizontal
OFFSET = 0.05  # m, from the axis to the rods' hinges and to the springs' ends on the slider
SPIN = 2.0 * math.pi  # rad/s


def flyball_governor(
    *,
    stiffness: NonNegative = STIFFNESS,
    damping: NonNegative = DAMPING,
    spin: float = SPIN,
    gravity: NonNegative = 9.81,
) -> Scene:
    """Spin a governor whose couplers are stiff spring-dampers, set off at one turn a second (IFToMM A05).

    stiffness (N/m), damping (N s/m), spin (rad/s about the vertical at the start), gravity (m/s^2).
    """
    mass = DENSITY * LENGTH * THICKNESS**2
    across, axial = mass * (LENGTH**2 + THICKNESS**2) / 12.0, mass * THICKNESS**2 / 6.0
    shaft = SpatialBody(
        name="shaft", mass=mass, inertia=(across, across, axial, 0.0, 0.0, 0.0),
        position=(0.0, 0.0, 0.5 * LENGTH), angular_velocity=(0.0, 0.0, spin),
    )  # fmt: skip
    cube = DENSITY * EDGE**3
    slider = SpatialBody(
        name="slider", mass=cube, inertia=(*[cube * EDGE**2 / 6.0] * 3, 0.0, 0.0, 0.0),
        position=(0.0, 0.0, SLIDER_HEIGHT), angular_velocity=(0.0, 0.0, spin),
    )  # fmt: skip
    sides = (("left", -1.0), ("right", 1.0))
    return Scene(
        name="flyball_governor",
        description="Shaft, slider and two rods with balls; stiff spring-dampers in place of coupler rods.",
        source="IFToMM Technical Committee for Multibody Dynamics, benchmark library, A05 Stiff flyball governor",
        duration=10.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(shaft, slider, *(_arm(name, side, mass, across, axial, spin) for name, side in sides)),
        joints=(
            Revolute(name="bearing", body_a=GROUND, body_b="shaft", point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0)),
            Prismatic(name="guide", body_a="shaft", body_b="slider", point=slider.position, axis=(0.0, 0.0, 1.0)),
            *(
                Revolute(name=f"hinge_{name}", body_a="shaft", body_b=f"arm_{name}",
                         point=(side * OFFSET, 0.0, LENGTH), axis=(0.0, 1.0, 0.0))
                for name, side in sides
            ),
        ),
        loads=tuple(
            SpringDamper(
                name=f"coupler_{name}", body_a="slider", body_b=f"arm_{name}",
                point_a=(side * OFFSET, 0.0, SLIDER_HEIGHT), point_b=_on_rod(side, 0.5 * LENGTH),
                stiffness=stiffness, damping=damping, rest_length=REST,
            )
            for name, side in sides
        ),
    )  # fmt: skip


def _on_rod(side: float, along: float) -> tuple[float, float, float]:
    return (side * (OFFSET + along * math.cos(DROOP)), 0.0, LENGTH - along * math.sin(DROOP))


def _arm(name: str, side: float, mass: float, across: float, axial: float, spin: float) -> SpatialBody:
    """A rod and its ball as one body, body x axis along the rod, outwards."""
    total = mass + BALL
    centre = (0.5 * mass + BALL) / total * LENGTH  # m, from the hinge
    joined = across + mass * (centre - 0.5 * LENGTH) ** 2 + BALL * (LENGTH - centre) ** 2
    position = _on_rod(side, centre)
    half = 0.5 * (DROOP if side > 0.0 else math.pi - DROOP)  # about y: x turns down
    return SpatialBody(
        name=f"arm_{name}", mass=total, inertia=(axial, joined, joined, 0.0, 0.0, 0.0), position=position,
        orientation=(math.cos(half), 0.0, math.sin(half), 0.0),
        velocity=(0.0, spin * position[0], 0.0), angular_velocity=(0.0, 0.0, spin),
    )  # fmt: skip
