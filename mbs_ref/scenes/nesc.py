"""NASA's check cases of atmospheric flight: spheres that fall over a turning Earth, and a tumbling brick."""

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from mbs_ref.scene import PointMass, Scene, SpatialBody
from mbs_ref.scene.base.part import NonNegative, Positive, dot
from mbs_ref.scene.celestial import CelestialLoad, Newton, Oblateness, StandardDrag
from mbs_ref.scene.euler_parameters import rotation_matrices

FOOT, SLUG = 0.3048, 14.593902937206364  # m, kg; international foot, slug of a pound-force
GM_EARTH = 3.986004418e14  # m^3/s^2, WGS-84
R_EARTH = 6_378_137.0  # m, WGS-84
J2 = 1.08262982e-3  # WGS-84, of the source
SPIN = 7.292115e-5  # rad/s, WGS-84
ALTITUDE = 30_000.0 * FOOT  # m


def nesc_dropped_sphere(*, duration: Positive = 30.0, j2: NonNegative = J2, spin: NonNegative = SPIN) -> Scene:
    """Let a sphere go 30 000 ft above the equator at longitude 0, at rest as seen from the turning ground.

    duration (s), j2 (of the Earth), spin (rad/s, of the Earth). Axes do not turn: z is the Earth's, x points to the
    start. Files of the published simulators are in Earth-fixed axes: their map states the spin.
    """
    field = Oblateness(name="earth_j2", body="earth", radius=R_EARTH, zonal=(j2,))
    words = "A sphere without drag falls from 30 000 ft over the equator of a turning, oblate Earth."
    return _dropped("nesc_dropped_sphere", words, "case 1", R_EARTH + ALTITUDE, spin, duration, field)


def _dropped(
    name: str, description: str, cases: str, radius: float, spin: float, duration: float, field: CelestialLoad
) -> Scene:
    """Return a sphere that is released over the equator, `radius` (m) from the Earth's centre, with a field more."""
    return Scene(
        name=name,
        description=description,
        source=f"Jackson, Shelton, Jackson, Castro, Hill, NASA/TM-2015-218675, atmospheric check {cases}",
        duration=duration,
        bodies=(
            PointMass(name="earth", mass=5.9722e24, position=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0)),
            PointMass(name="sphere", mass=SLUG, position=(radius, 0.0, 0.0), velocity=(0.0, spin * radius, 0.0)),
        ),
        loads=(Newton(name="newton", gm=(GM_EARTH, 0.0), radius=(0.0, 0.0)), field),
    )


R_MEAN = 6_371_007.1809  # m, mean radius of the source (20 902 255.199 ft, a foot being 1 / 3.28084 m there)
AREA = 0.1963495 * FOOT**2  # m^2, of the six-inch sphere
DRAG_COEFFICIENT = 0.1


def nesc_sphere_in_air(*, duration: Annotated[float, Field(gt=0.0, le=60.0)] = 30.0, spin: NonNegative = SPIN) -> Scene:
    """Let a sphere go 30 000 ft above the equator, at rest as seen from the ground, in the 1976 standard atmosphere.

    duration (s; after 60 the sphere is 5 km below sea level, where the tables of the air end), spin (rad/s, of the
    Earth and its air): as given check case 5, with 0 check case 4. Axes do not turn: z is the Earth's, x points to the
    start.
    """
    air = StandardDrag(
        name="air", body="sphere", planet="earth", coefficient=DRAG_COEFFICIENT * AREA / SLUG, radius=R_MEAN, spin=spin
    )
    words = "A sphere with drag falls from 30 000 ft over the equator of a round Earth, in standard air."
    return _dropped("nesc_sphere_in_air", words, "cases 4 and 5", R_MEAN + ALTITUDE, spin, duration, air)


BRICK_MASS = 0.155404754 * SLUG  # kg
ROLL, PITCH, YAW = (moment * SLUG * FOOT**2 for moment in (0.001894220, 0.006211019, 0.007194665))  # kg m^2
RATES_DEG = (10.0, 20.0, 30.0)  # deg/s, roll, pitch, yaw about body axes, against the stars
BRICK_LEVEL = (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0)  # body x, y, z north, east, down at latitude and longitude 0


def nesc_tumbling_brick(*, duration: Positive = 30.0) -> Scene:
    """Let a brick with three different moments of inertia tumble, no torque acting.

    duration (s). Axes do not turn: z is the Earth's, x points from its centre to the start over the equator. The brick
    falls as the sphere of case 1 does, which turns nothing; the scene stays with its centre of mass.
    """
    omega = dot(rotation_matrices(np.array(BRICK_LEVEL)), np.radians(RATES_DEG))
    return Scene(
        name="nesc_tumbling_brick",
        description="A brick tumbles freely, 10, 20 and 30 deg/s about its principal axes.",
        source="Jackson, Shelton, Jackson, Castro, Hill, NASA/TM-2015-218675, atmospheric check case 2",
        duration=duration,
        bodies=(
            SpatialBody(
                name="brick", mass=BRICK_MASS, inertia=(ROLL, PITCH, YAW, 0.0, 0.0, 0.0), orientation=BRICK_LEVEL,
                angular_velocity=tuple(omega.tolist()),
            ),
        ),
    )  # fmt: skip
