"""A chain of uniform rods: the scaling problem of recursive and constraint-based solvers."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import GROUND, PlanarBody, Revolute, Scene
from mbs_ref.scene.base.part import Positive

LINK_LENGTH = 1.0  # m
LINK_MASS = 1.0  # kg
LINK_INERTIA = LINK_MASS * LINK_LENGTH**2 / 12.0  # kg m^2, uniform thin rod about its centre


def build(*, links: Annotated[int, Field(ge=1, le=100_000)] = 10, gravity: Positive = 9.81) -> Scene:
    """Drop a chain of unit rods, hinged to ground at one end, from the horizontal.

    links (number of rods), gravity (m/s^2).
    """
    rods = [f"link{k + 1}" for k in range(links)]
    return Scene(
        name="pendulum_chain",
        description=f"{links} uniform rods of 1 m and 1 kg in a row, released horizontally from rest.",
        source="A common scaling problem of multibody codes; every figure here is a unit or follows from one",
        duration=1.0,
        gravity=(0.0, -gravity),
        bodies=tuple(
            PlanarBody(name=rod, mass=LINK_MASS, inertia=LINK_INERTIA, position=((k + 0.5) * LINK_LENGTH, 0.0))
            for k, rod in enumerate(rods)
        ),
        joints=tuple(
            Revolute(name=f"hinge{k + 1}", body_a=before, body_b=rod, point=(k * LINK_LENGTH, 0.0))
            for k, (before, rod) in enumerate(pairwise([GROUND, *rods]))
        ),
    )
