"""A ball on a seat that moves: shaken up and down, or free and turning."""

from typing import Literal

from mbs_ref.scene import CoordinateDrive, PlanarBody, Scene, contact
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.signals import Constant, Harmonic
from mbs_ref.scenes.bouncing import law_of

RADIUS = 0.05  # m


def ball_on_driven_seat(
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
    chosen = law_of(law, stiffness=stiffness, damping=damping, release="force")
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
            contact.CircleOnLine(
                name="seat", body_a="ball", center=(0.0, RADIUS), radius=RADIUS, body_b="seat",
                point_1=(-0.5, 0.0), point_2=(0.5, 0.0), extent="segment", law=chosen,
            ),
        ),
    )  # fmt: skip


def ball_on_moving_seat(
    *,
    law: Literal["spring_damper", "progressive"] = "spring_damper",
    stiffness: Positive = 1e4,
    damping: NonNegative = 10.0,
    friction: NonNegative = 0.3,
    offset: float = 0.3,
    seat_mass: Positive = 3.0,
    spin: float = 0.2,
) -> Scene:
    """Throw a ball on a free, turning seat with round ends; momentum is conserved to roundoff.

    contact law, stiffness (N/m), damping (N s/m, or N s/m^2 if progressive), friction (mu), where the ball
    starts along the seat (m, from its middle; the seat ends at 0.5), mass (kg) and spin (rad/s) of the seat.
    """
    start = (offset, RADIUS + 0.1)
    return Scene(
        name="ball_on_moving_seat",
        description="A ball meets a finite surface on a body that moves and turns.",
        source="Momentum balance",
        duration=1.0,
        bodies=(
            PlanarBody(name="ball", mass=1.0, inertia=0.001, position=start, velocity=(0.3, -1.0)),
            PlanarBody(name="seat", mass=seat_mass, inertia=0.5, position=(0.0, -0.1), angular_velocity=spin),
        ),
        contacts=(
            contact.CircleOnLine(
                name="seat", body_a="ball", center=start, radius=RADIUS, body_b="seat", point_1=(-0.5, 0.0),
                point_2=(0.5, 0.0), extent="capped", law=law_of(law, stiffness=stiffness, damping=damping),
                friction=contact.RegularisedCoulomb(coefficient=friction, speed=0.05) if friction else None,
            ),
        ),
    )  # fmt: skip
