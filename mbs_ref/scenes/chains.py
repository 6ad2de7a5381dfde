"""Chains of rods: hinged in the plane, on ball joints in space, and the N-four-bar mechanism with its loops."""

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any

from pydantic import Field

from mbs_ref.scene import GROUND, Joint, PlanarBody, Revolute, Scene, SpatialBody, Spherical
from mbs_ref.scene.base.part import Positive

LINK_LENGTH = 1.0  # m
LINK_MASS = 1.0  # kg
LINK_INERTIA = LINK_MASS * LINK_LENGTH**2 / 12.0  # kg m^2, uniform thin rod about its centre


def pendulum_chain(*, links: Annotated[int, Field(ge=1, le=100_000)] = 10, gravity: Positive = 9.81) -> Scene:
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


LINK_AXIAL = 0.01 * LINK_INERTIA  # kg m^2, a rod of some thickness
SIDEWAYS = 1.0  # rad/s, of the whole chain about the vertical at the start


def spatial_chain(*, links: Annotated[int, Field(ge=1, le=100_000)] = 10, gravity: Positive = 9.81) -> Scene:
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
        name=name, mass=LINK_MASS, inertia=(LINK_AXIAL, LINK_INERTIA, LINK_INERTIA, 0.0, 0.0, 0.0),
        position=(reach, 0.0, 0.0), velocity=(0.0, SIDEWAYS * reach, 0.0), angular_velocity=(0.0, 0.0, SIDEWAYS),
    )  # fmt: skip


START_SPEED = 1.0  # m/s, of B0 along x
UPRIGHT = 1.5707963267948966  # rad


def n_four_bar(*, loops: Annotated[int, Field(ge=1, le=10_000)] = 2, gravity: Positive = 9.81) -> Scene:
    """Tip a row of parallelogram four-bar loops through their singular flat poses (IFToMM A02).

    loops (number of four-bars; 2 loops + 1 rods), gravity (m/s^2).
    """
    return Scene(
        name="n_four_bar",
        description=f"{loops + 1} cranks joined by {loops} couplers, set off upright at 1 m/s through singular poses.",
        source="IFToMM Technical Committee for Multibody Dynamics, benchmark library, A02 N-four-bar mechanism",
        duration=10.0,
        gravity=(0.0, -gravity),
        bodies=tuple(_cranks_and_couplers(loops)),
        joints=tuple(joint for k in range(loops + 1) for joint in _joints(k, loops)),
    )


def _cranks_and_couplers(loops: int) -> Iterator[PlanarBody]:
    shared: dict[str, Any] = {"mass": LINK_MASS, "inertia": LINK_INERTIA}
    for k in range(loops + 1):
        yield PlanarBody(
            name=f"crank{k}", position=(k * LINK_LENGTH, 0.5 * LINK_LENGTH), angle=UPRIGHT,
            velocity=(0.5 * START_SPEED, 0.0), angular_velocity=-START_SPEED / LINK_LENGTH, **shared,
        )  # fmt: skip
    for k in range(loops):
        place = ((k + 0.5) * LINK_LENGTH, LINK_LENGTH)
        yield PlanarBody(name=f"coupler{k}", position=place, velocity=(START_SPEED, 0.0), **shared)


def _joints(k: int, loops: int) -> list[Joint]:
    """The hinges at the foot A_k and the tip B_k of crank k."""
    tip = (k * LINK_LENGTH, LINK_LENGTH)
    joints: list[Joint] = [Revolute(name=f"A{k}", body_a=GROUND, body_b=f"crank{k}", point=(k * LINK_LENGTH, 0.0))]
    if k > 0:
        joints.append(Revolute(name=f"B{k}.left", body_a=f"coupler{k - 1}", body_b=f"crank{k}", point=tip))
    if k < loops:
        joints.append(Revolute(name=f"B{k}.right", body_a=f"crank{k}", body_b=f"coupler{k}", point=tip))
    return joints


OUT_OF_PLANE = 0.01  # of the in-plane moment: the rod's axial one, which nothing turns


def spatial_n_four_bar(*, loops: Annotated[int, Field(ge=1, le=1_000)] = 2, gravity: Positive = 9.81) -> Scene:
    """Tip the N-four-bar (IFToMM A02) with spatial bodies and hinges: three redundant rows a loop.

    loops (number of four-bars; 2 loops + 1 rods), gravity (m/s^2).
    """
    plane = n_four_bar(loops=loops, gravity=gravity)
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
