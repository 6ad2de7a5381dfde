"""The car axis of the test set for initial value problem solvers: stiffly sprung, on a road that moves one wheel."""

from mbs_ref import scene as parts
from mbs_ref.scene.signals import Harmonic

LENGTH, HEIGHT = 1.0, 0.5  # m, of the axis; of the springs at rest
MASS = 5e-4  # kg, of each end: M epsilon^2 / 2 of the source with M = 10, epsilon = 0.01
AMPLITUDE, OMEGA = 0.1, 10.0  # m, rad/s, of the right wheel on its road


def car_axis() -> parts.Scene:
    """Drive an axis on two springs: one wheel rolls flat, the other over waves (IVP test set, problem car axis).

    The source's first constraint keeps the left end square above the left wheel: here a slide on the massless line
    between the wheels, a driven body whose mass no motion depends on.
    """
    speed = AMPLITUDE * OMEGA  # m/s, of the right wheel at t = 0
    lean = -HEIGHT * speed / LENGTH  # m/s, of both ends: they lean with the road
    return parts.Scene(
        name="car_axis",
        description="Two point masses, held apart by a rod and up by springs, over a road that lifts one wheel.",
        source="Mazzia and Magherini, Test Set for Initial Value Problem Solvers, release 2.4 (2008), car axis; "
        "Schneider, Integration von Deskriptorsystemen (1988)",
        duration=3.0,
        gravity=(0.0, -1.0),
        bodies=(
            parts.PlanarBody(name="road", mass=1.0, inertia=1.0, position=(LENGTH, 0.0), velocity=(0.0, speed),
                             angular_velocity=speed / LENGTH),
            parts.PlanarBody(name="left", mass=MASS, inertia=MASS, position=(0.0, HEIGHT), velocity=(lean, 0.0),
                             angular_velocity=speed / LENGTH),
            parts.PointMass(name="right", mass=MASS, position=(LENGTH, HEIGHT), velocity=(lean, 0.0)),
        ),
        joints=(
            parts.Revolute(name="left_wheel", body_a=parts.GROUND, body_b="road", point=(0.0, 0.0)),
            parts.CoordinateDrive(name="waves", body="road", coordinate="y",
                                  motion=Harmonic(amplitude=AMPLITUDE, omega=OMEGA)),
            parts.Prismatic(name="slide", body_a="road", body_b="left", point=(0.0, HEIGHT), axis=(0.0, 1.0)),
            parts.Distance(name="axis", body_a="left", body_b="right", point_a=(0.0, HEIGHT), point_b=(LENGTH, HEIGHT)),
        ),
        loads=(
            parts.SpringDamper(name="left_spring", body_a=parts.GROUND, body_b="left", point_a=(0.0, 0.0),
                               point_b=(0.0, HEIGHT), stiffness=1.0, rest_length=HEIGHT),
            parts.SpringDamper(name="right_spring", body_a="road", body_b="right", point_a=(LENGTH, 0.0),
                               point_b=(LENGTH, HEIGHT), stiffness=1.0, rest_length=HEIGHT),
        ),
    )  # fmt: skip
