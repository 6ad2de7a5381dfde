"""Spinning bodies: Euler's top, Lagrange's top, two gyroscopes in a row, and the tippe top."""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import GROUND, Scene, SpatialBody, Spherical
from mbs_ref.scene.base.part import Positive, dot
from mbs_ref.scene.euler_parameters import rotation_matrices


def torque_free_top(
    *,
    turns: Annotated[float, Field(gt=0.0, le=1e6)] = 100.0,
    spin: Positive = 10.0,
    axis: Literal[1, 2, 3] = 2,
    tilt: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.1,
    inertia_1: Positive = 1.0,
    inertia_2: Positive = 2.0,
    inertia_3: Positive = 3.0,
) -> Scene:
    """Spin a free body nearly about one principal axis and let it turn many times.

    turns (duration in turns at `spin`), spin (rad/s about the chosen axis), axis (1, 2 or 3; the one with
    the intermediate moment tumbles), tilt (rates about the other two axes, as a share of spin), inertia_1,
    inertia_2, inertia_3 (principal moments, kg m^2). The body starts turned away from the world axes.
    """
    omega = np.full(3, tilt * spin)
    omega[axis - 1] = spin
    start = np.array([1.0, 2.0, 3.0, 4.0]) / math.sqrt(30.0)  # a turn of no special kind
    return Scene(
        name="torque_free_top",
        description=f"A free rigid body, {turns:g} turns at {spin:g} rad/s about its principal axis {axis}.",
        source="Landau and Lifshitz, Mechanics, 3rd ed., sec. 37; exact in Jacobi's elliptic functions",
        duration=turns * 2.0 * math.pi / spin,
        bodies=(
            SpatialBody(
                name="top", mass=1.0, inertia=(inertia_1, inertia_2, inertia_3, 0.0, 0.0, 0.0),
                orientation=tuple(start.tolist()), angular_velocity=tuple(dot(rotation_matrices(start), omega)),
            ),
        ),
    )  # fmt: skip


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
