"""The N-four-bar mechanism, problem A02 of the IFToMM benchmark library."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mbs_ref.scene import GROUND, Joint, PlanarBody, Revolute, Scene
from mbs_ref.scene.base.part import Positive

LINK_LENGTH = 1.0  # m
LINK_MASS = 1.0  # kg
LINK_INERTIA = LINK_MASS * LINK_LENGTH**2 / 12.0  # kg m^2, uniform thin rod about its centre
START_SPEED = 1.0  # m/s, of B0 along x
UPRIGHT = 1.5707963267948966  # rad


def build(*, loops: Annotated[int, Field(ge=1, le=10_000)] = 2, gravity: Positive = 9.81) -> Scene:
    """Tip a row of parallelogram four-bar loops through their singular flat poses (IFToMM A02).

    loops (number of four-bars; 2 loops + 1 rods), gravity (m/s^2).
    """
    return Scene(
        name="n_four_bar",
        description=f"{loops + 1} cranks joined by {loops} couplers, set off upright at 1 m/s through singular poses.",
        source="IFToMM Technical Committee for Multibody Dynamics, benchmark library, A02 N-four-bar mechanism",
        duration=10.0,
        gravity=(0.0, -gravity),
        bodies=(*(_crank(k) for k in range(loops + 1)), *(_coupler(k) for k in range(loops))),
        joints=tuple(joint for k in range(loops + 1) for joint in _joints(k, loops)),
    )


def _crank(k: int) -> PlanarBody:
    return PlanarBody(
        name=f"crank{k}", mass=LINK_MASS, inertia=LINK_INERTIA,
        position=(k * LINK_LENGTH, 0.5 * LINK_LENGTH), angle=UPRIGHT,
        velocity=(0.5 * START_SPEED, 0.0), angular_velocity=-START_SPEED / LINK_LENGTH,
    )  # fmt: skip


def _coupler(k: int) -> PlanarBody:
    return PlanarBody(
        name=f"coupler{k}", mass=LINK_MASS, inertia=LINK_INERTIA,
        position=((k + 0.5) * LINK_LENGTH, LINK_LENGTH), velocity=(START_SPEED, 0.0),
    )  # fmt: skip


def _joints(k: int, loops: int) -> list[Joint]:
    """The hinges at the foot A_k and the tip B_k of crank k."""
    tip = (k * LINK_LENGTH, LINK_LENGTH)
    joints: list[Joint] = [Revolute(name=f"A{k}", body_a=GROUND, body_b=f"crank{k}", point=(k * LINK_LENGTH, 0.0))]
    if k > 0:
        joints.append(Revolute(name=f"B{k}.left", body_a=f"coupler{k - 1}", body_b=f"crank{k}", point=tip))
    if k < loops:
        joints.append(Revolute(name=f"B{k}.right", body_a=f"crank{k}", body_b=f"coupler{k}", point=tip))
    return joints
