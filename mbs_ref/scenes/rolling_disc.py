"""A disc thrown along rough ground without spin: friction turns sliding into rolling."""

from __future__ import annotations

from mbs_ref.scene import PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnLine, SpringDamperLaw, StickSlip

RADIUS = 0.1  # m


def build(
    *,
    friction: Positive = 0.3,
    speed: Positive = 2.0,
    mass: Positive = 1.0,
    inertia_factor: Positive = 0.5,
    stiffness: Positive = 1e5,
    damping: NonNegative = 200.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Throw a disc along rough ground: it ends rolling at v0 / (1 + I/(m r^2)).

    A uniform disc keeps 2/3 of its speed, a sphere (inertia_factor 0.4) 5/7. friction (mu), speed (m/s),
    mass (kg), inertia_factor I/(m r^2), contact stiffness (N/m) and damping (N s/m), gravity (m/s^2).
    """
    center = (0.0, RADIUS - mass * gravity / stiffness)
    return Scene(
        name="rolling_disc",
        description="A disc thrown without spin slides, then rolls.",
        source="Textbook; Coriolis, Theorie mathematique des effets du jeu de billard, 1835",
        duration=1.0,
        gravity=(0.0, -gravity),
        bodies=(
            PlanarBody(
                name="disc", mass=mass, inertia=inertia_factor * mass * RADIUS**2, position=center,
                velocity=(speed, 0.0),
            ),
        ),
        contacts=(
            CircleOnLine(
                name="ground", body_a="disc", center=center, radius=RADIUS, point_1=(0.0, 0.0), point_2=(1.0, 0.0),
                law=SpringDamperLaw(stiffness=stiffness, damping=damping, release="force"),
                friction=StickSlip(coefficient=friction, stiffness=stiffness, damping=damping),
            ),
        ),
    )  # fmt: skip
