"""Spinning bodies: Euler's top, Lagrange's top, two gyroscopes in a row, and the tippe top."""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbs_ref.scene import GROUND, Scene, SpatialBody, Spherical
from mbs_ref.scene.base.part import Positive, dot
from mbs_ref.scene.contact import RegularisedCoulomb, SphereOnPlane, SpringDamperLaw
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


GYRO_MASS, GYRO_HALF = 1.0, 0.25  # kg; m, from a joint to the centre of mass
GYRO_AXIAL, GYRO_ACROSS = 0.02, 0.03  # kg m^2


def double_gyroscope(*, spin: float = 80.0, second_spin: float = -50.0, gravity: Positive = 9.81) -> Scene:
    """Let two spinning gyroscopes go, joined to each other and to ground by spherical joints, axes horizontal.

    spin, second_spin (rad/s about their own axes), gravity (m/s^2).
    """
    return Scene(
        name="double_gyroscope",
        description="Two gyroscopes on spherical joints, axes horizontal and at rest at the start, spinning fast.",
        source="Two of Lagrange's tops in a row; every figure here is a choice",
        duration=2.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(_wheel("first", GYRO_HALF, spin), _wheel("second", 3.0 * GYRO_HALF, second_spin)),
        joints=(
            Spherical(name="pivot", body_a=GROUND, body_b="first", point=(0.0, 0.0, 0.0)),
            Spherical(name="link", body_a="first", body_b="second", point=(2.0 * GYRO_HALF, 0.0, 0.0)),
        ),
    )


def _wheel(name: str, reach: float, spin: float) -> SpatialBody:
    return SpatialBody(
        name=name, mass=GYRO_MASS, inertia=(GYRO_AXIAL, GYRO_ACROSS, GYRO_ACROSS, 0.0, 0.0, 0.0),
        position=(reach, 0.0, 0.0), angular_velocity=(spin, 0.0, 0.0),
    )  # fmt: skip


TIPPE_MASS = 6e-3  # kg
BALL, STEM = (0.015, 0.003), (0.005, 0.016)  # m: radius, and how far its centre is above the top's centre of mass


def tippe_top(
    *, friction: Positive = 0.3, spin: Positive = 180.0, tilt: Positive = 0.1, stiffness: Positive = 1e4,
    slip: Positive = 1e-2, gravity: Positive = 9.81,
) -> Scene:  # fmt: skip
    """Spin a tippe top on rough ground: friction turns it upside down, and it goes on spinning on its stem.

    friction (mu), spin (rad/s, about the vertical), tilt (rad), stiffness (N/m) of the ground, slip (m/s) below which
    friction fades, gravity (m/s^2). While its ball alone touches, Jellett's integral is constant: the angular momentum
    along the way from the centre of mass to the lowest point.
    """
    sine, cosine, depth = math.sin(tilt), math.cos(tilt), TIPPE_MASS * gravity / stiffness
    axis, place = np.array([sine, 0.0, cosine]), np.array([0.0, 0.0, BALL[0] - depth - BALL[1] * cosine])
    law = SpringDamperLaw(stiffness=stiffness, damping=0.2 * math.sqrt(stiffness * TIPPE_MASS), release="force")
    grip = RegularisedCoulomb(coefficient=friction, speed=slip)
    return Scene(
        name="tippe_top", description="A ball with a low centre of mass and a stem spins on rough ground.",
        source="Leine, Glocker, Eur. J. Mech. A 22 (2003) 193-216; Jellett, Treatise on the Theory of Friction (1872)",
        duration=4.0, gravity=(0.0, 0.0, -gravity),
        bodies=(
            SpatialBody(
                name="top", mass=TIPPE_MASS, inertia=(8e-7, 8e-7, 7e-7, 0.0, 0.0, 0.0), position=tuple(place.tolist()),
                orientation=(math.cos(0.5 * tilt), 0.0, math.sin(0.5 * tilt), 0.0), angular_velocity=(0.0, 0.0, spin),
            ),
        ),
        contacts=tuple(
            SphereOnPlane(
                name=name, body_a="top", center=tuple((place + height * axis).tolist()), radius=radius,
                point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0), law=law, friction=grip,
            )
            for name, (radius, height) in (("ball", BALL), ("stem", STEM))
        ),
    )  # fmt: skip
