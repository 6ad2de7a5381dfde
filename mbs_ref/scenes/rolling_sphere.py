"""A sphere thrown along rough ground: friction turns sliding into rolling, on a curved path if it spins aside."""

from __future__ import annotations

import math
from typing import Literal

from mbs_ref.scene import Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import SphereOnPlane, SpringDamperLaw, StickSlip
from mbs_ref.scene.inertia import sphere

RADIUS = 0.1  # m


def build(
    *,
    friction: Positive = 0.3,
    speed: Positive = 2.0,
    heading: float = 0.6,
    spin: float = 0.0,
    mass: Positive = 1.0,
    stiffness: Positive = 1e5,
    damping: NonNegative = 200.0,
    release: Literal["gap", "force"] = "force",
    gravity: Positive = 9.81,
) -> Scene:
    """Throw a sphere along rough ground: without spin it rolls at 5/7 of its speed after 2 v0/(7 mu g).

    friction (mu), speed (m/s) and its heading (rad, from x), spin (rad/s, about the direction of travel, which
    bends the path: a masse shot), mass (kg), contact stiffness (N/m) and damping (N s/m) and
    where it lets go (it never does), gravity (m/s^2).
    """
    center = (0.0, 0.0, RADIUS - mass * gravity / stiffness)
    c, s = math.cos(heading), math.sin(heading)
    return Scene(
        name="rolling_sphere",
        description="A sphere thrown along rough ground slides, then rolls.",
        source="Coriolis, Theorie mathematique des effets du jeu de billard, 1835",
        duration=1.0,
        gravity=(0.0, 0.0, -gravity),
        bodies=(
            SpatialBody(
                name="ball", mass=mass, inertia=sphere(mass, RADIUS), position=center,
                velocity=(speed * c, speed * s, 0.0), angular_velocity=(spin * c, spin * s, 0.0),
            ),
        ),
        contacts=(
            SphereOnPlane(
                name="ground", body_a="ball", center=center, radius=RADIUS, point=(0.0, 0.0, 0.0),
                normal=(0.0, 0.0, 1.0), law=SpringDamperLaw(stiffness=stiffness, damping=damping, release=release),
                friction=StickSlip(coefficient=friction, stiffness=stiffness, damping=damping),
            ),
        ),
    )  # fmt: skip
