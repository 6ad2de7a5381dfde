"""Bodies that roll on rough ground: discs, a sphere and Euler's disk."""

import math
from typing import Annotated, Literal

from pydantic import Field

from mbs_ref.scene import PlanarBody, RollingWheel, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive
from mbs_ref.scene.bodies import sphere_inertia
from mbs_ref.scene.contact import CircleOnLine, SphereOnPlane, SpringDamperLaw, StickSlip

RADIUS = 0.1  # m


def rolling_disc(
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


def rolling_sphere(
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
    its release rule (it never opens), gravity (m/s^2).
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
                name="ball", mass=mass, inertia=sphere_inertia(mass, RADIUS), position=center,
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


def oblique_disc(
    *,
    speed_down: Positive = 1.0,
    speed_along: float = 3.0,
    friction: NonNegative = 0.2,
    mass: Positive = 1.0,
    stiffness: Positive = 1e5,
    damping: NonNegative = 100.0,
) -> Scene:
    """Throw a disc obliquely; while it slides all along, friction takes mu (1 + e) v_n from v_t.

    speed_down and speed_along (m/s), friction (mu), mass (kg), contact stiffness (N/m) and damping (N s/m).
    """
    center = (0.0, RADIUS + 0.1)
    return Scene(
        name="oblique_disc",
        description="A disc hits rough ground obliquely, without gravity.",
        source="Textbook; Whittaker, Analytical Dynamics, sec. 95",
        duration=0.3,
        bodies=(
            PlanarBody(
                name="disc", mass=mass, inertia=0.5 * mass * RADIUS**2, position=center,
                velocity=(speed_along, -speed_down),
            ),
        ),
        contacts=(
            CircleOnLine(
                name="ground", body_a="disc", center=center, radius=RADIUS, point_1=(0.0, 0.0), point_2=(1.0, 0.0),
                law=SpringDamperLaw(stiffness=stiffness, damping=damping),
                friction=StickSlip(coefficient=friction, stiffness=stiffness),
            ),
        ),
    )  # fmt: skip


def euler_disk(*, tilt: Annotated[float, Field(ge=2.0, le=85.0)] = 20.0, gravity: Positive = 9.81) -> Scene:
    """Roll a thin disc round a circle so that its centre rests: Euler's disk before it loses energy.

    tilt (deg) of the disc from the ground, gravity (m/s^2). It precesses at sqrt(4 g/(r sin tilt)), and nothing slows
    it: rolling resistance and air, which end the toy's motion, are left out.
    """
    bend, mass, radius = math.radians(tilt), 0.44, 0.0375  # kg and m of the toy
    sine, cosine = math.sin(bend), math.cos(bend)
    rate = math.sqrt(4.0 * gravity / (radius * sine))  # rad/s, of precession
    centre, axis, across = (0.0, 0.0, radius * sine), (sine, 0.0, cosine), 0.25 * mass * radius**2
    disc = SpatialBody(
        name="disc", mass=mass, inertia=(across, across, 2.0 * across, 0.0, 0.0, 0.0), position=centre,
        orientation=(math.cos(0.5 * bend), 0.0, math.sin(0.5 * bend), 0.0),
        angular_velocity=(-rate * sine * cosine, 0.0, rate * sine * sine),
    )  # fmt: skip
    return Scene(
        name="euler_disk", description=f"A thin disc at {tilt:g} degrees rolls round a circle; its centre rests.",
        source="Kessler, O'Reilly, Regular and Chaotic Dynamics 7 (2002) 49-60; Moffatt, Nature 404 (2000) 833-834",
        duration=1.0, gravity=(0.0, 0.0, -gravity), bodies=(disc,),
        joints=(
            RollingWheel(name="ground", body="disc", point=centre, axis=axis, radius=radius, normal=(0.0, 0.0, 1.0)),
        ),
    )  # fmt: skip
