"""Lagrange's top: a spinning body with a fixed point."""

import math
from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.scene import GROUND, Scene, SpatialBody, Spherical
from mbs_ref.scene.base.part import Positive

ARM_MASS, ARM = 1.0, 0.3  # kg; m, from the fixed point to the centre of mass
TOP_AXIAL, TOP_TRANSVERSE = 0.02, 0.04  # kg m^2, about the centre of mass


def heavy_top(
    *,
    motion: Literal["steady", "nutation"] = "nutation",
    spin: Positive = 60.0,
    tilt: Annotated[float, Field(gt=0.0, lt=3.14)] = 0.6,
    gravity: Positive = 9.81,
) -> Scene:
    """Precess a spinning top steadily, or let it go with its axis at rest so that it nutates in cusps.

    motion ("steady" or "nutation"), spin (rad/s, about the top's axis and along it), tilt (rad, of the axis
    from the vertical), gravity (m/s^2). ValueError where the spin is too slow for steady precession.
    """
    precession = steady_precession(spin, tilt, gravity) if motion == "steady" else 0.0
    sine, cosine = math.sin(tilt), math.cos(tilt)
    along = spin  # omega about the top's own axis, precession included
    # about the axis e = (sin, 0, cos): omega = precession z - precession cos e + along e
    share = along - precession * cosine
    omega = (share * sine, 0.0, precession + share * cosine)
    centre = (ARM * sine, 0.0, ARM * cosine)
    velocity = (0.0, omega[2] * centre[0] - omega[0] * centre[2], 0.0)
    return Scene(
        name="heavy_top",
        description=f"A symmetric top with a fixed point, {spin:g} rad/s about its axis, {motion}.",
        source="Goldstein, Classical Mechanics, 2nd ed., sec. 5-7",
        duration=2.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(
            SpatialBody(
                name="top", mass=ARM_MASS, inertia=(TOP_TRANSVERSE, TOP_TRANSVERSE, TOP_AXIAL, 0.0, 0.0, 0.0),
                position=centre,
                orientation=(math.cos(tilt / 2.0), 0.0, math.sin(tilt / 2.0), 0.0),
                velocity=velocity, angular_velocity=omega,
            ),
        ),
        joints=(Spherical(name="pivot", body_a=GROUND, body_b="top", point=(0.0, 0.0, 0.0)),),
    )  # fmt: skip


def steady_precession(spin: float, tilt: float, gravity: float) -> float:
    """Return the slow root of A Omega^2 cos(tilt) - C spin Omega + m g l = 0 (rad/s), A about the fixed point."""
    about_pivot = TOP_TRANSVERSE + ARM_MASS * ARM**2
    weight = ARM_MASS * gravity * ARM
    discriminant = (TOP_AXIAL * spin) ** 2 - 4.0 * about_pivot * math.cos(tilt) * weight
    if discriminant < 0.0:
        least = math.sqrt(4.0 * about_pivot * math.cos(tilt) * weight) / TOP_AXIAL
        raise ValueError(f"heavy_top: spin = {spin} rad/s is too slow for steady precession; at least {least:.6g}")
    return 2.0 * weight / (TOP_AXIAL * spin + math.sqrt(discriminant))
