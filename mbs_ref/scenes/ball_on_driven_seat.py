"""A ball on a seat that shakes: it lifts off where the seat falls away faster than the ball can."""

from __future__ import annotations

from typing import Literal

from mbs_ref.scene import CoordinateDrive, PlanarBody, Scene
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.contact import CircleOnLine, ConstraintLaw, ContactLaw, SpringDamperLaw
from mbs_ref.scene.signals import Constant, Harmonic

RADIUS = 0.05  # m


def build(
    *,
    law: Literal["constraint", "spring_damper"] = "constraint",
    amplitude: Positive = 0.02,
    omega: Positive = 30.0,
    mass: Positive = 1.0,
    stiffness: Positive = 1e5,
    damping: NonNegative = 600.0,
    gravity: Positive = 9.81,
) -> Scene:
    """Shake a ball up and down on a seat, y = amplitude sin(omega t): it leaves where A w^2 sin(w t) = g.

    law: the constraint that stands for the force while contact lasts, or the spring-damper force itself;
    amplitude (m), omega (rad/s), mass (kg) of the ball, stiffness (N/m) and damping (N s/m) of the
    spring-damper, gravity (m/s^2).
    """
    chosen: ContactLaw = (
        ConstraintLaw()
        if law == "constraint"
        else SpringDamperLaw(stiffness=stiffness, damping=damping, release="force")
    )
    speed = (0.0, amplitude * omega)
    drives = {"x": Constant(value=0.0), "y": Harmonic(amplitude=amplitude, omega=omega), "angle": Constant(value=0.0)}
    return Scene(
        name="ball_on_driven_seat",
        description="A ball rests on a shaken seat, leaves it and lands on it again.",
        source="Fox 2001, equivalent constraints; P. J. Holmes, J. Sound Vib. 84 (1982) 173 with restitution 0",
        duration=1.0,
        gravity=(0.0, -gravity),
        bodies=(
            PlanarBody(
                name="ball", mass=mass, inertia=0.4 * mass * RADIUS**2, position=(0.0, RADIUS), velocity=speed
            ),
            PlanarBody(name="seat", mass=2.0, inertia=0.1, position=(0.0, 0.0), velocity=speed),
        ),
        joints=tuple(
            CoordinateDrive(name=f"seat.{axis}", body="seat", coordinate=axis, motion=motion)  # type: ignore[arg-type]
            for axis, motion in drives.items()
        ),
        contacts=(
            CircleOnLine(
                name="seat", body_a="ball", center=(0.0, RADIUS), radius=RADIUS, body_b="seat",
                point_1=(-0.5, 0.0), point_2=(0.5, 0.0), extent="segment", law=chosen,
            ),
        ),
    )  # fmt: skip
