"""The simple pendulum, problem A01 of the IFToMM benchmark library."""

from __future__ import annotations

from mbs_ref.scene import GROUND, Distance, PointMass, Scene
from mbs_ref.scene.base.part import Positive


def build(*, length: Positive = 1.0, mass: Positive = 1.0, gravity: Positive = 9.81) -> Scene:
    """Swing a point mass on a massless rod, released horizontally from rest (IFToMM A01).

    length (m), mass (kg), gravity (m/s^2).
    """
    start = (-length, 0.0)
    return Scene(
        name="pendulum",
        description="A point mass at the end of a massless rod, released from rest at the height of the pivot.",
        source="IFToMM Technical Committee for Multibody Dynamics, benchmark library, A01 Simple pendulum",
        duration=10.0,
        gravity=(0.0, -gravity),
        bodies=(PointMass(name="bob", mass=mass, position=start, velocity=(0.0, 0.0)),),
        joints=(Distance(name="rod", body_a=GROUND, body_b="bob", point_a=(0.0, 0.0), point_b=start, length=length),),
    )
