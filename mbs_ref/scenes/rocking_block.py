"""A slender block let go from a tilt: it rocks from edge to edge."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnLine, RegularisedCoulomb, SpringDamperLaw

WIDTH, HEIGHT = 0.2, 0.8  # m


def build(
    *,
    tilt: Annotated[float, Field(gt=0.0, lt=0.2)] = 0.1,
    mass: Positive = 10.0,
    stiffness: Positive = 1e6,
    damping: NonNegative = 2000.0,
    friction: NonNegative = 0.8,
    gravity: Positive = 9.81,
) -> Scene:
    """Rock a block between its two lower edges.

    tilt at the start (rad; below the angle of balance, atan(1/4)), mass (kg), contact stiffness (N/m) and
    damping (N s/m) of each edge, friction (mu), gravity (m/s^2).
    """
    c, s = math.cos(tilt), math.sin(tilt)
    sink = mass * gravity / stiffness

    def world(x: float, y: float) -> tuple[float, float]:
        """Return a point given from the lower left edge, on which the block stands."""
        return c * x - s * y, s * x + c * y - sink

    law = SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    grip = RegularisedCoulomb(coefficient=friction, speed=0.01) if friction else None
    return Scene(
        name="rocking_block",
        description="A slender block rocks from edge to edge.",
        source="G. W. Housner, Bull. Seism. Soc. Am. 53 (1963) 403",
        duration=2.0,
        gravity=(0.0, -gravity),
        bodies=(
            PlanarBody(
                name="block", mass=mass, inertia=mass * (WIDTH**2 + HEIGHT**2) / 12.0,
                position=world(0.5 * WIDTH, 0.5 * HEIGHT), angle=tilt,
            ),
        ),
        contacts=tuple(
            CircleOnLine(
                name=f"edge.{side}", body_a="block", center=world(x, 0.0), radius=0.0, point_1=(-1.0, 0.0),
                point_2=(1.0, 0.0), law=law, friction=grip,
            )
            for side, x in (("left", 0.0), ("right", WIDTH))
        ),
    )  # fmt: skip
