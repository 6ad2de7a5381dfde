"""Two heavy gyroscopes in a row, hung on spherical joints."""

from __future__ import annotations

from mbs_ref.scene import GROUND, Scene, SpatialBody, Spherical
from mbs_ref.scene.base.part import Positive

MASS, HALF = 1.0, 0.25  # kg; m, from a joint to the centre of mass
AXIAL, ACROSS = 0.02, 0.03  # kg m^2


def build(*, spin: float = 80.0, second_spin: float = -50.0, gravity: Positive = 9.81) -> Scene:
    """Let two spinning gyroscopes go, joined to each other and to ground by spherical joints, axes horizontal.

    spin, second_spin (rad/s about their own axes), gravity (m/s^2).
    """
    return Scene(
        name="double_gyroscope",
        description="Two gyroscopes on spherical joints, axes horizontal and at rest at the start, spinning fast.",
        source="Two of Lagrange's tops in a row; every figure here is a choice",
        duration=2.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(_wheel("first", HALF, spin), _wheel("second", 3.0 * HALF, second_spin)),
        joints=(
            Spherical(name="pivot", body_a=GROUND, body_b="first", point=(0.0, 0.0, 0.0)),
            Spherical(name="link", body_a="first", body_b="second", point=(2.0 * HALF, 0.0, 0.0)),
        ),
    )


def _wheel(name: str, reach: float, spin: float) -> SpatialBody:
    return SpatialBody(
        name=name, mass=MASS, inertia=(AXIAL, ACROSS, ACROSS, 0.0, 0.0, 0.0),
        position=(reach, 0.0, 0.0), angular_velocity=(spin, 0.0, 0.0),
    )  # fmt: skip
