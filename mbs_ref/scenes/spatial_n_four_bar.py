"""The N-four-bar mechanism modelled in space: every loop has redundant rows."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import Field

from mbs_ref.scene import Revolute, Scene, SpatialBody
from mbs_ref.scene.base.part import Positive
from mbs_ref.scenes import n_four_bar

OUT_OF_PLANE = 0.01  # of the in-plane moment: the rod's axial one, which nothing turns


def build(*, loops: Annotated[int, Field(ge=1, le=1_000)] = 2, gravity: Positive = 9.81) -> Scene:
    """Tip the N-four-bar (IFToMM A02) with spatial bodies and hinges: three redundant rows a loop.

    loops (number of four-bars; 2 loops + 1 rods), gravity (m/s^2).
    """
    plane = n_four_bar.build(loops=loops, gravity=gravity)
    return Scene(
        name="spatial_n_four_bar",
        description=f"{plane.description} Modelled in space.",
        source=plane.source,
        duration=plane.duration,
        gravity=(0.0, -gravity, 0.0),
        bodies=tuple(_lifted(body) for body in plane.bodies),
        joints=tuple(
            Revolute(name=j.name, body_a=j.body_a, body_b=j.body_b, point=(*j.point, 0.0), axis=(0.0, 0.0, 1.0))
            for j in plane.joints
            if isinstance(j, Revolute)
        ),
    )


def _lifted(body: Any) -> SpatialBody:
    half = 0.5 * body.angle
    return SpatialBody(
        name=body.name, mass=body.mass,
        inertia=(OUT_OF_PLANE * body.inertia, body.inertia, body.inertia, 0.0, 0.0, 0.0),
        position=(*body.position, 0.0), orientation=(math.cos(half), 0.0, 0.0, math.sin(half)),
        velocity=(*body.velocity, 0.0), angular_velocity=(0.0, 0.0, body.angular_velocity),
    )  # fmt: skip
