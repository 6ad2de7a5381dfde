"""A chain of rods with spherical joints, falling and swinging sideways."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

from pydantic import Field

from mbs_ref.scene import GROUND, Scene, SpatialBody, Spherical
from mbs_ref.scene.base.part import Positive

LINK_LENGTH = 1.0  # m
LINK_MASS = 1.0  # kg
ACROSS = LINK_MASS * LINK_LENGTH**2 / 12.0  # kg m^2, uniform thin rod about its centre
AXIAL = 0.01 * ACROSS  # kg m^2, a rod of some thickness
SIDEWAYS = 1.0  # rad/s, of the whole chain about the vertical at the start


def build(*, links: Annotated[int, Field(ge=1, le=100_000)] = 10, gravity: Positive = 9.81) -> Scene:
    """Drop a chain of unit rods on spherical joints from the horizontal while it turns about the vertical.

    links (number of rods), gravity (m/s^2).
    """
    rods = [f"link{k + 1}" for k in range(links)]
    return Scene(
        name="spatial_chain",
        description=f"{links} rods of 1 m and 1 kg on spherical joints, released horizontally, turning at 1 rad/s.",
        source="The pendulum chain in space; every figure here is a unit or follows from one",
        duration=1.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=tuple(_rod(name, (k + 0.5) * LINK_LENGTH) for k, name in enumerate(rods)),
        joints=tuple(
            Spherical(name=f"ball{k + 1}", body_a=before, body_b=rod, point=(k * LINK_LENGTH, 0.0, 0.0))
            for k, (before, rod) in enumerate(pairwise([GROUND, *rods]))
        ),
    )


def _rod(name: str, reach: float) -> SpatialBody:
    return SpatialBody(
        name=name, mass=LINK_MASS, inertia=(AXIAL, ACROSS, ACROSS, 0.0, 0.0, 0.0), position=(reach, 0.0, 0.0),
        velocity=(0.0, SIDEWAYS * reach, 0.0), angular_velocity=(0.0, 0.0, SIDEWAYS),
    )  # fmt: skip
